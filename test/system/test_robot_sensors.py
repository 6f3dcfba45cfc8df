"""The topics of several sensors on one robot."""
import itertools
import math

import pytest

from img_recog_helpers.sdf import BUILT_IN, sdf
from img_recog_helpers.sdf_robot import POST, ROBOT, WALL
from img_recog_helpers.simulator_tools import Echo, burger, complaints
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
    rows = Echo(ros, '/ears/ear/range').wait_more(4)
    assert {round(row[0], 3) for row in rows} == {0.5, 0.7}
    for topic, kind in (('/front', 'LaserScan'), ('/back', 'LaserScan'), ('/ears/ear', 'Range')):
        ros.wait_run('Type: sensor_msgs/' + kind, 'rostopic', 'info', topic)
    assert 'nowhere' in ros.run('rostopic', 'echo', '-n', '1', '/front/header/frame_id')
    seen = ros.run('rostopic', 'echo', '-n', '2', '/ears/ear')
    assert 'frame_id: "ear_left"' in seen and 'frame_id: "ear_right"' in seen
    assert 'radiation_type: 0' in seen and 'field_of_view: 0.3' in seen
    assert '/scan' in ros.run('rostopic', 'list', '-p').split()     # the burger's own
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
    node = simulate('_world:={}'.format(world), '_x_pos:=0', '_y_pos:=0', urdf=burger(''.join(
        sensor(library, '<topicName>{}</topicName>'.format(topic)).replace(
            one, scan.format(samples, rows)) for library, topic, samples, rows in (
                ('gazebo_ros_laser', 'rows', 200, 100), ('gazebo_ros_laser', 'row', 16384, 1),
                ('gazebo_ros_range', 'near', 100, 100)))))
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
    driver = ros.start('rostopic', 'pub', '-r', '10', '/bot/cmd_vel', 'geometry_msgs/Twist',
                       '{linear: {x: 0.5}}')
    wait_for(lambda: front.rows[-1][0] < 3.5, lambda: node.output)
    driver.interrupt()
    assert 'child_frame_id: "base"' in ros.run('rostopic', 'echo', '-n', '1', '/bot/odom')
    assert 'left_joint' in ros.run('rostopic', 'echo', '-n', '1', '/bot/joint_states')
    tilt = ros.run('rostopic', 'echo', '-n', '1', '/bot/tilt/linear_acceleration')
    assert 'z: 9.' in tilt
    topics = ros.run('rostopic', 'list', '-p').split()
    assert not [each for each in topics if 'bare' in each]
    assert node.interrupt() == 0
    assert complaints(node) == []
