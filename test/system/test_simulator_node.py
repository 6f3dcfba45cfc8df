"""The simulator as a process: refused input, parameters and tags, and robustness."""
import math
import re

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, PoseStamped, Quaternion
from std_msgs.msg import Header

from img_recog_helpers import wire
from img_recog_helpers.process_table import descendants, is_alive
from img_recog_helpers.simulator_tools import (Echo, Images, burger, call, complaints, drawing,
                                               drive, wait_standing, with_tags)
from img_recog_helpers.waiting import wait_for

pytestmark = pytest.mark.usefixtures('shared_ros')       # one master


SONAR = ('<gazebo reference="base_link"><sensor type="sonar" name="ear">'
         '<plugin name="ear" filename="libgazebo_ros_range.so"/></sensor></gazebo>')


@pytest.mark.parametrize('parameter, addition, named', [
    ('', SONAR, 'libgazebo_ros_range.so'),
    ('_wheel_seperation:=0.2', '', 'wheel_seperation is unknown to this node: did you mean '
                                   'wheel_separation?')], ids=['sonar', 'typo'])
def test_warns_and_continues(simulate, parameter, addition, named):
    node = simulate(*filter(None, [parameter]), urdf=burger(addition))
    node.wait_output('simulating 1.0017 kg')
    assert node.interrupt() == 0
    lines = complaints(node)
    assert len(lines) == 1 and lines[0].startswith('[WARN]') and named in lines[0], node.output
    assert 'Traceback' not in node.output


def test_a_sensor_without_its_link_has_no_topic(ros, simulate):
    node = simulate(urdf=burger().replace('reference="imu_link"', 'reference="torso"'))
    node.wait_output('simulating 1.0017 kg')
    topics = ros.run('rostopic', 'list').split()
    assert '/scan' in topics and '/imu' not in topics


# -- parameters and tags

def test_a_robot_without_a_drive_has_its_sensors_and_takes_no_commands(ros, simulate):
    node = simulate(urdf=re.sub('(?s)<plugin name="drive".*?</plugin>', '', burger()))
    node.wait_output('simulating 1.0017 kg')
    line, = complaints(node)
    assert 'robot_description: it does not drive, as it has no drive that is simulated;' in line
    ros.wait_run('ranges:', 'rostopic', 'echo', '-n', '1', '/scan')
    assert '/cmd_vel' not in ros.run('rostopic', 'list', '-s').split()
    assert '/odom' not in ros.run('rostopic', 'list').split()


def test_gazebo_tags_are_used(ros, simulate):
    simulate('_real_time_factor:=5', '_world:=empty', '_publish_odom_tf:=false', urdf=with_tags(
        odometryTopic='my_odom', odometryFrame='my_odom_frame', samples='90').replace(
            '<update_rate>5<', '<update_rate>10<').replace('<topicName>scan<',
                                                           '<topicName>my_scan<'))
    transforms = ros.start('rostopic', 'echo', '/tf')
    stamps = Echo(ros, '/my_scan/header/stamp').wait_more(3)[:3]
    assert np.diff(stamps, axis=0).tolist() == [[1e8], [1e8]]
    assert 'ranges: "<array type: float32, length: 90>"' in ros.run(
        'rostopic', 'echo', '--noarr', '-n', '1', '/my_scan')
    topics = ros.run('rostopic', 'list', '-p').split()
    assert {'/my_odom', '/my_scan', '/imu'} <= set(topics)
    assert not {'/odom', '/scan'} & set(topics)
    assert 'my_odom_frame' in ros.run('rostopic', 'echo', '-n', '1', '/my_odom/header')
    assert 'frame_id' not in transforms.output


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
    assert '/gazebo' in ros.run('rosnode', 'list').split()
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


def test_the_real_time_factor_is_published(ros, simulate):
    simulate()
    factor = Echo(ros, '/gazebo/real_time_factor')
    factor.wait(lambda value: 0.5 < value < 1.1, 'real time')
    call(ros, 'pause_physics')
    factor.wait(lambda value: value == 0.0, 'standing still')


def set_parameters(ros, text):
    ros.run('rosrun', 'dynamic_reconfigure', 'dynparam', 'set', 'gazebo', text)


def test_the_real_time_factor_is_changed_while_it_runs(ros, simulate):
    node = simulate('_world:=empty', '_cmd_vel_timeout:=0.5', '_real_time_factor:=1')
    factor, place = Echo(ros, '/gazebo/real_time_factor'), Echo(ros, '/odom/pose/pose/position')
    set_parameters(ros, "{'real_time_factor': 4}")
    factor.wait(lambda value: 2.0 < value < 4.2, 'four times real time')
    # a command lasts 0.5 s of wall time, 2 s of simulated time
    drive(ros, 0.2)
    place.wait(lambda x, y, z: x > -1.95, 'the robot to leave')
    assert wait_standing(place)[0] == pytest.approx(-1.6, abs=0.05)
    set_parameters(ros, "{'real_time_factor': -1}")
    wait_for(lambda: any('real_time_factor' in line and '0.001 to 1000' in line
                         for line in complaints(node)),
             lambda: 'a refusal in:\n' + node.output)


def test_the_robot_is_moved_by_set_pose(ros, simulate):
    node = simulate('_world:=empty')
    place = Echo(ros, '/odom/pose/pose/position')
    place.wait(lambda x, y, z: True, 'odometry')
    publisher = wire.RawPublisher(ros.master_uri, '/gazebo/set_pose', PoseStamped)
    ros.stack.callback(publisher.close)

    def send_until(effect, what, frame='', x=0.0, y=0.0, w=1.0):
        """Send a pose again and again: warnings are throttled."""
        msg = PoseStamped(Header(frame_id=frame),
                          Pose(Point(x, y, 0.0), Quaternion(0.0, 0.0, 0.0, w)))
        wait_for(lambda: publisher.publish(msg) and effect(), what)
    send_until(lambda: place.rows[-1][:2] == pytest.approx([1.0, -2.0], abs=0.01), 'the place',
               x=1.0, y=-2.0)
    for words, bad in (('finite', {'x': math.nan}),
                       ("frame is 'base_link'", {'frame': 'base_link'}),
                       ('quaternion of zeros', {'x': 3.0, 'w': 0.0}),
                       ('numbers up to', {'x': 1e12})):
        send_until(lambda words=words: words in node.output, words, **bad)
    assert place.wait_more(3)[-1][:2] == pytest.approx([1.0, -2.0], abs=0.01)


def test_outlines_of_the_world(ros, simulate):
    simulate()
    outlines = ros.start('rostopic', 'echo', '/gazebo/world_outlines/markers')
    # nine pillars, and the walls
    wait_for(lambda: outlines.output.count('ns: "outlines"') > 9, 'outlines')
    assert 'frame_id: "odom"' in outlines.output
