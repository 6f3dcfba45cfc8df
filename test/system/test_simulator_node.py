"""The simulator as a process: refused input, parameters and tags, and robustness."""
import math
import re

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from std_msgs.msg import Header

from img_recog_helpers import wire
from img_recog_helpers.process_table import descendants, is_alive
from img_recog_helpers.service_calls import ServiceCalls
from img_recog_helpers.simulator_tools import (Echo, Images, Messages, burger, complaints, drawing,
                                               drive, published, wait_standing, with_tags)
from img_recog_helpers.waiting import wait_for

pytestmark = pytest.mark.usefixtures('shared_ros')       # one master


SONAR = ('<gazebo reference="base_link"><sensor type="sonar" name="ear">'
         '<plugin name="ear" filename="libgazebo_ros_range.so"/></sensor></gazebo>')


def test_what_is_not_simulated_is_named_and_the_rest_works(ros, simulate):
    node = simulate('_wheel_seperation:=0.2', urdf=re.sub(
        '(?s)<plugin name="drive".*?</plugin>', '', burger(SONAR)).replace(
            'reference="imu_link"', 'reference="torso"'))
    node.wait_output('simulating 1.0017 kg')
    Echo(ros, '/scan/header/stamp').wait_more(1)
    # a sensor without its link has no topic; a robot without a drive takes no commands
    assert not {'/imu', '/odom'} & published(ros)
    assert '/cmd_vel' not in dict(ros.master().getSystemState('/test')[2][1])
    assert node.interrupt() == 0
    lines = complaints(node)
    assert len(lines) == 4 and all(line.startswith('[WARN]') for line in lines), node.output
    for named in ('sensor sonar, plugin libgazebo_ros_range.so', 'torso',
                  'robot_description: it does not drive, as it has no drive that is simulated;',
                  'wheel_seperation is unknown to this node: did you mean wheel_separation?'):
        assert len([line for line in lines if named in line]) == 1, (named, lines)
    assert 'Traceback' not in node.output


# -- parameters and tags

def test_gazebo_tags_are_used(ros, simulate):
    simulate('_real_time_factor:=5', '_world:=empty', '_publish_odom_tf:=false', urdf=with_tags(
        odometryTopic='my_odom', odometryFrame='my_odom_frame', samples='90').replace(
            '<update_rate>5<', '<update_rate>10<').replace('<topicName>scan<',
                                                           '<topicName>my_scan<'))
    transforms = Messages(ros, '/tf')
    wait_for(transforms.is_connected.is_set, 'a connection')
    stamps = Echo(ros, '/my_scan/header/stamp').wait_more(3)[:3]
    assert np.diff(stamps, axis=0).tolist() == [[1e8], [1e8]]
    assert len(Messages(ros, '/my_scan').wait_more(1)[0].ranges) == 90
    assert {'/my_odom', '/my_scan', '/imu'} <= published(ros)
    assert not {'/odom', '/scan'} & published(ros)
    assert Messages(ros, '/my_odom').wait_more(1)[0].header.frame_id == 'my_odom_frame'
    assert transforms.rows == []


def test_a_second_simulator_takes_over(ros, simulate, tmp_path):
    folder = tmp_path / 'tmp'
    folder.mkdir()
    first = simulate(env=dict(ros.env, TMPDIR=str(folder)))
    Images(ros).wait()
    children = descendants(first.pid)
    assert drawing(first) in children

    second = simulate()
    assert first.wait() == 0
    assert 'Traceback' not in first.output
    wait_for(lambda: not any(map(is_alive, children)), lambda: children)
    assert list(folder.iterdir()) == []
    second.wait_output('simulating 1.0017 kg')
    for topic in ('/clock/clock', '/odom/pose/pose/position'):
        Echo(ros, topic).wait_more(10)
    assert wire.pid_of(ros.master_uri, '/gazebo') == second.pid
    assert second.interrupt() == 0


def test_a_subscriber_that_hangs_does_not_block_the_simulator(ros, simulate):
    simulate('_real_time_factor:=0', '_world:=empty', '_odometry_period_s:=0.001',
             '_publish_odom_tf:=false')
    clock = Echo(ros, '/clock/clock')
    stopped = Echo(ros, '/odom/header/stamp', buffer_bytes=4096)
    stopped.wait_more(10)
    stopped.hang(True)
    try:
        since = clock.wait_more(1)[-1][0]
        # 1000 messages of 0.7 kB a second are more than the 4 MB that the sender's socket may hold
        clock.wait(lambda now: now > since + 20e9, '20 s of simulated time')
    finally:
        stopped.hang(False)

    def gap():
        stamps = [row[0] for row in stopped.rows]
        return max((b - a for a, b in zip(stamps, stamps[1:])), default=0) > 5e9
    # more was sent than socket buffers hold: some messages are missing, then new ones arrive
    wait_for(gap, lambda: stopped.rows[-3:])
    stopped.wait_more(10)
    # several times are sent together, none is left out
    times = [row[0] for row in clock.rows]
    assert {time % 10e6 for time in times} == {0} and 10e6 in np.diff(times)


def test_a_running_simulator_is_asked_and_told(ros, simulate):
    node = simulate('_cmd_vel_timeout:=0.5', '_real_time_factor:=1')
    services = ServiceCalls(ros)
    place = Echo(ros, '/odom/pose/pose/position')
    place.wait(lambda x, y, z: True, 'odometry')
    markers = Messages(ros, '/gazebo/world_outlines').wait_more(1)[0].markers
    # nine pillars, and the walls
    assert len([marker for marker in markers if marker.ns == 'outlines']) > 9
    assert {marker.header.frame_id for marker in markers} == {'odom'}
    check_the_real_time_factor(ros, node, place, services)
    check_set_pose(ros, node, place)
    services.close()


def check_the_real_time_factor(ros, node, place, services):
    factor = Echo(ros, '/gazebo/real_time_factor')

    def set_factor(value):
        services.call('/gazebo/set_parameters', {'config': {'doubles': [
            {'name': 'real_time_factor', 'value': value}]}})
    factor.wait(lambda value: 0.5 < value < 1.1, 'real time')
    set_factor(4.0)
    factor.wait(lambda value: 2.0 < value < 4.2, 'four times real time')
    # a command lasts 0.5 s of wall time, 2 s of simulated time
    drive(ros, 0.2)
    place.wait(lambda x, y, z: x > -1.95, 'the robot to leave')
    assert wait_standing(place)[0] == pytest.approx(-1.6, abs=0.05)
    set_factor(-1.0)
    wait_for(lambda: any('real_time_factor' in line and '0.001 to 1000' in line
                         for line in complaints(node)),
             lambda: 'a refusal in:\n' + node.output)
    services.call('/gazebo/pause_physics', {})
    factor.wait(lambda value: value == 0.0, 'standing still')
    services.call('/gazebo/unpause_physics', {})


def check_set_pose(ros, node, place):
    publisher = wire.RawPublisher(ros.master_uri, '/gazebo/set_pose', PoseStamped)
    ros.stack.callback(publisher.close)

    def send_until(effect, what, frame='', x=0.0, y=0.0, w=1.0):
        """Send a pose again and again: warnings are throttled."""
        msg = PoseStamped(Header(frame_id=frame),
                          Pose(Point(x, y, 0.0), Quaternion(0.0, 0.0, 0.0, w)))
        wait_for(lambda: publisher.publish(msg) and effect(), what)
    send_until(lambda: place.rows[-1][:2] == pytest.approx([0.5, -0.5], abs=0.01), 'the place',
               x=0.5, y=-0.5)
    for words, bad in (('finite', {'x': math.nan}),
                       ("frame is 'base_link'", {'frame': 'base_link'}),
                       ('quaternion of zeros', {'x': 3.0, 'w': 0.0}),
                       ('numbers up to', {'x': 1e12})):
        send_until(lambda words=words: words in node.output, words, **bad)
    assert place.wait_more(3)[-1][:2] == pytest.approx([0.5, -0.5], abs=0.01)
