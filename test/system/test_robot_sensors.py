"""The topics of several sensors on one robot."""
import itertools
import math

import pytest
from geometry_msgs.msg import Twist

from img_recog_helpers import wire
from img_recog_helpers.sdf import BUILT_IN, sdf
from img_recog_helpers.sdf_robot import POST, ROBOT, WALL
from img_recog_helpers.simulator_tools import Echo, Messages, burger, complaints
from img_recog_helpers.waiting import wait_for

pytestmark = pytest.mark.usefixtures('shared_ros')       # one master


def sensor(library, plugin, yaw=0.0, far=3.0, kind='ray'):
    return ('<gazebo reference="base_scan"><sensor type="{}" name="s"><pose>0 0 0 0 0 {}</pose>'
            '<update_rate>20</update_rate><ray><range><min>0.1</min><max>{}</max></range><scan>'
            '<horizontal><samples>1</samples></horizontal></scan></ray>'
            '<plugin name="p" filename="lib{}.so">{}</plugin></sensor></gazebo>').format(
                kind, yaw, far, library, plugin)


def test_each_sensor_has_its_topic_and_those_of_a_kind_can_share_one(ros, simulate):
    ears = ''.join(
        sensor('gazebo_ros_range', '<robotNamespace>/ears</robotNamespace>'
               '<topicName>ear</topicName><frameName>ear_{}</frameName>'
               '<radiation>ultrasound</radiation><fov>0.3</fov>'
               .format(side), far=far) for side, far in (('left', 0.5), ('right', 0.7)))
    node = simulate('_world:=empty', urdf=burger(
        sensor('gazebo_ros_laser', '<topicName>front</topicName><frameName>nowhere</frameName>')
        + sensor('gazebo_ros_gpu_laser', '<topicName>/back</topicName>', 3.14, kind='gpu_ray')
        + ears))
    node.wait_output('simulating')
    # two ranges that nothing is in, in turn
    seen = Messages(ros, '/ears/ear').wait_more(4)
    assert {(msg.header.frame_id, round(msg.range, 3)) for msg in seen} == {
        ('ear_left', 0.5), ('ear_right', 0.7)}
    assert {(msg.radiation_type, round(msg.field_of_view, 3)) for msg in seen} == {(0, 0.3)}
    types = dict(ros.master().getTopicTypes('/test')[2])
    for topic, kind in (('/front', 'LaserScan'), ('/back', 'LaserScan'), ('/ears/ear', 'Range'),
                        ('/scan', 'LaserScan')):        # the burger's own
        assert types[topic] == 'sensor_msgs/' + kind
    assert Messages(ros, '/front').wait_more(1)[0].header.frame_id == 'nowhere'
    assert node.interrupt() == 0
    assert complaints(node) == []


def test_sensors_of_very_many_rays(ros, simulate, tmp_path):
    # a tetrahedron, whose rays PyBullet casts: a corner far behind, and a face 2 m ahead
    (tmp_path / 'face.stl').write_text('solid s\n{}endsolid s\n'.format(''.join(
        'facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n'.format(''.join(
            'vertex {} {} {}\n'.format(*corner) for corner in corners))
        for corners in itertools.combinations(((2, -9, -9), (2, 9, -9), (2, 0, 9), (9, 0, 0)), 3))
    ))
    world = tmp_path / 'face.sdf'
    world.write_text(sdf(BUILT_IN, (
        '<model name="face"><static>1</static><link name="l"><collision name="c"><geometry><mesh>'
        '<uri>{}/face.stl</uri></mesh></geometry></collision></link></model>').format(tmp_path)))
    scan = ('<samples>{}</samples><min_angle>-0.3</min_angle><max_angle>0.3</max_angle>'
            '</horizontal><vertical><samples>{}</samples><min_angle>-0.02</min_angle>'
            '<max_angle>0.02</max_angle></vertical>')
    one = '<samples>1</samples></horizontal>'
    sensors = ''.join(
        sensor(library, '<topicName>{}</topicName>'.format(topic)).replace(
            one, scan.format(samples, rows)) for library, topic, samples, rows in (
                ('gazebo_ros_laser', 'rows', 200, 100), ('gazebo_ros_laser', 'row', 16384, 1),
                ('gazebo_ros_range', 'near', 100, 100)))
    node = simulate('_world:={}'.format(world), '_x_pos:=0', '_y_pos:=0',
                    urdf=burger(sensors.replace('_rate>20<', '_rate>5<')))
    node.wait_output('simulating')
    # of the rows, the middle one; base_scan is 3 cm behind the origin
    for topic, count in (('rows', 200), ('row', 16384)):
        increment, = Echo(ros, '/{}/angle_increment'.format(topic)).wait_more(1)[0]
        assert increment == pytest.approx(0.6 / (count - 1))
        for index, angle in ((0, 0.3), (count // 2, 0.0), (count - 1, 0.3)):
            value, = Echo(ros, '/{}/ranges[{}]'.format(topic, index)).wait_more(1)[0]
            assert value == pytest.approx(2.032 / math.cos(angle), abs=5e-3)
    assert Echo(ros, '/near/range').wait_more(1)[0][0] == pytest.approx(2.032, abs=5e-3)
    assert node.interrupt() == 0
    assert len(complaints(node)) == 1       # of the rows above and below the middle one


def test_models_of_a_world_drive_and_measure_by_their_plugins(ros, simulate, tmp_path):
    world = tmp_path / 'bots.sdf'
    robot = ROBOT.format('<robotNamespace>bot</robotNamespace>')
    world.write_text(sdf(BUILT_IN, WALL, POST, robot))
    node = simulate('_world:={}'.format(world))
    node.wait_output('simulating')
    # from the post at x 0, and from the robot at x -1, to the wall at 2.9
    assert Echo(ros, '/watch/ranges[0]').wait_more(1)[0][0] == pytest.approx(2.9, abs=1e-3)
    front = Echo(ros, '/bot/front/ranges[0]')
    assert front.wait_more(1)[0][0] == pytest.approx(3.9, abs=0.01)
    command = Twist()
    command.linear.x = 0.5
    driver = wire.RawPublisher(ros.master_uri, '/bot/cmd_vel', Twist)
    ros.stack.callback(driver.close)
    wait_for(lambda: driver.publish(command) and front.rows[-1][0] < 3.5, lambda: node.output)
    odometry, joints, tilt = (Messages(ros, '/bot/' + name).wait_more(1)[0]
                              for name in ('odom', 'joint_states', 'tilt'))
    assert odometry.child_frame_id == 'base' and 'left_joint' in joints.name
    assert 9.0 < tilt.linear_acceleration.z < 10.0
    assert not [topic for topic, _ in ros.master().getTopicTypes('/test')[2] if 'bare' in topic]
    assert node.interrupt() == 0
    assert complaints(node) == []
