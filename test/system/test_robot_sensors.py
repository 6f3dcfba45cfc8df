"""The topics of several sensors on one robot."""
import pytest

from img_recog_testing.simulator_tools import Echo, burger, complaints

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
    assert '/scan' not in ros.run('rostopic', 'list', '-p').split()
    assert node.interrupt() == 0
    assert complaints(node) == []
