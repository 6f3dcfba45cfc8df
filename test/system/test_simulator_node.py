"""The simulator as a process: what it takes, what it gives, and what it survives."""
import copy
import json
import os
import re
import signal
import sys
import xmlrpc.client

import pytest

from waiting import wait_for

BURGER = os.path.join(os.path.dirname(__file__), '..', '..', 'urdf', 'turtlebot3_burger.urdf')


def burger(addition=''):
    """Return the text of the burger's URDF with something added at its end."""
    with open(BURGER) as file:
        return file.read().replace('</robot>', addition + '</robot>')


@pytest.fixture
def ros(roscore):
    """The master of this module; what a test starts is ended after it."""
    ros = copy.copy(roscore)
    ros._processes = []
    yield ros
    for process in ros._processes:
        if process._popen.poll() is None:
            os.kill(process.pid, signal.SIGINT)         # all at once, it takes half a second
    ros.close()


@pytest.fixture
def simulate(ros):
    """A function that starts the simulator."""
    master = xmlrpc.client.ServerProxy(ros.env['ROS_MASTER_URI'])

    def start(*parameters, urdf=None, **popen):
        if master.hasParam('/test', '/gazebo')[2]:
            master.deleteParam('/test', '/gazebo')
        master.setParam('/test', '/robot_description', urdf or burger())
        return ros.start('rosrun', 'img_recog', 'pybullet_sim.py', *parameters, **popen)
    return start


class Echo:
    """Some numbers of a topic, as `rostopic echo` prints them: a row for each message."""

    def __init__(self, ros, topic):
        self._process = ros.start('rostopic', 'echo', '-p', topic)
        self.pid = self._process.pid

    @property
    def rows(self):
        _, _, table = self._process.output.partition('%time')
        lines = table.split('\n')[1:-1]
        return [[float(word) for word in line.split(',')[1:]] for line in lines]

    def wait(self, accept, what):
        """Return the newest row once `accept` says that it is as wanted."""
        def newest():
            rows = self.rows
            return rows[-1:] if rows and accept(*rows[-1]) else None
        return wait_for(newest, lambda: '{}; the newest are {}'.format(what, self.rows[-3:]))[0]

    def wait_more(self, count):
        """Return all rows once there are `count` more than now."""
        goal = len(self.rows) + count
        wait_for(lambda: len(self.rows) >= goal, lambda: '{} rows'.format(goal))
        return self.rows

    def close(self):
        self._process.close()


def drive(ros, linear):
    """Send one command."""
    return ros.start('rostopic', 'pub', '/cmd_vel', 'geometry_msgs/Twist',
                     '{{linear: {{x: {}}}}}'.format(linear))


def call(ros, service):
    assert ros.run('rosservice', 'call', '/gazebo/' + service).strip() == ''


def complaints(node):
    """Return what a simulator found wrong, but for a busy machine."""
    return [line for line in re.findall(r'\[(?:WARN|ERROR|FATAL)\].*', node.output)
            if 'this machine is too slow' not in line]


def descendants(pid):
    """Return the process ids below `pid` and their command lines."""
    parents, found = {}, {}
    for entry in filter(str.isdigit, os.listdir('/proc')):
        try:
            with open('/proc/{}/stat'.format(entry)) as file:
                parents[int(entry)] = int(file.read().rpartition(')')[2].split()[1])
            with open('/proc/{}/cmdline'.format(entry)) as file:
                found[int(entry)] = file.read().replace('\0', ' ')
        except OSError:
            continue            # it has ended meanwhile
    below = {pid}
    for _ in parents:
        below |= {child for child, parent in parents.items() if parent in below}
    return {child: found[child] for child in below - {pid} if child in found}


def drawing(node):
    """Return the id of the process that draws for a simulator, or None."""
    return next((pid for pid, line in descendants(node.pid).items() if 'spawn_main' in line), None)


def cpu_ticks(pid):
    with open('/proc/{}/stat'.format(pid)) as file:
        fields = file.read().rpartition(')')[2].split()
    return int(fields[11]) + int(fields[12])


# -- bad input

WIDE = ('<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">'
        '<wheelSeparation>wide</wheelSeparation></plugin></gazebo>')


def wheel_mass(mass):
    return burger().replace('value="0.02849894"', 'value="{}"'.format(mass), 1)


REFUSED = {
    'scan period': ('_scan_period_s:=0.0335', burger, 'scan_period_s: got 0.0335 s',
                    'set 0.033 or 0.034'),
    'odometry source': ('_odometry_source:=gps', burger, "/gazebo/odometry_source: got 'gps'",
                        'one of encoder, world'),
    'view': ('_view:=below', burger, "/gazebo/view: got 'below'", 'one of above, follow'),
    'base frame': ('_base_frame:=nowhere', burger, 'no link nowhere', 'base_footprint, base_link'),
    'wheel without mass': ('', lambda: wheel_mass('0'), 'mass of link wheel_left_link: got 0',
                           'more than 0'),
    'wheel of NaN mass': ('', lambda: wheel_mass('nan'), 'mass of link wheel_left_link: got',
                          'finite number'),
    'tag': ('', lambda: burger(WIDE), "<wheelSeparation> of plugin drive: got 'wide'",
            'a finite number'),
}


@pytest.mark.parametrize('parameter, urdf, named, advice', list(REFUSED.values()),
                         ids=list(REFUSED))
def test_refuses(simulate, parameter, urdf, named, advice):
    node = simulate(*filter(None, [parameter]), urdf=urdf())
    assert node.wait() == 1, node.output
    lines = [line for line in node.output.splitlines() if '[FATAL]' in line]
    assert len(lines) == 1 and 'Traceback' not in node.output, node.output
    assert named in lines[0] and advice in lines[0], lines[0]


MESH = ('<link name="cover"><visual><geometry><mesh filename="package://no_such_package/x.stl"/>'
        '</geometry></visual></link><joint name="cover_joint" type="fixed">'
        '<parent link="base_link"/><child link="cover"/></joint>')
CAMERA = ('<gazebo reference="base_link"><sensor type="camera" name="eye">'
          '<plugin name="eye" filename="libgazebo_ros_camera.so"/></sensor></gazebo>')


@pytest.mark.parametrize('parameter, addition, named', [
    ('', MESH, 'package://no_such_package/x.stl'),
    ('', CAMERA, 'libgazebo_ros_camera.so'),
    ('_wheel_seperation:=0.2', '', 'wheel_seperation is not one of this node: did you mean '
                                   'wheel_separation?')], ids=['mesh', 'camera', 'typo'])
def test_warns_and_goes_on(simulate, parameter, addition, named):
    node = simulate(*filter(None, [parameter]), urdf=burger(addition))
    node.wait_output('simulating 1.0017 kg')
    assert node.interrupt() == 0
    lines = complaints(node)
    assert len(lines) == 1 and lines[0].startswith('[WARN]') and named in lines[0], node.output
    assert 'Traceback' not in node.output


# -- parameters and tags

def test_commands_are_cut_off_at_the_limit(ros, simulate):
    simulate('_real_time_factor:=10', '_world:=empty', '_max_linear_velocity:=0.22')
    speed = Echo(ros, '/odom/twist/twist/linear')
    drive(ros, 10.0)
    speed.wait(lambda x, y, z: x > 0.215, 'full speed')
    rows = speed.wait_more(60)
    assert max(x for x, _, _ in rows) < 0.225
    assert [x for x, _, _ in rows[-50:]] == pytest.approx([0.22] * 50, abs=0.005)


def test_a_command_that_none_follows_ends(ros, simulate):
    simulate('_real_time_factor:=10', '_world:=empty', '_cmd_vel_timeout:=0.5')
    place = Echo(ros, '/odom/pose/pose/position')
    place.wait(lambda x, y, z: True, 'odometry')
    drive(ros, 0.2)
    place.wait(lambda x, y, z: x > -1.95, 'the robot to leave')
    # at 0.2 m/s for 0.5 s; both ends are ramps of 0.2 s
    rows = wait_for(lambda: place.rows[-30:] if standing(place.rows[-30:]) else None,
                    lambda: place.rows[-30:])
    assert rows[-1][0] == pytest.approx(-1.9, abs=0.02)


def standing(rows):
    """Return whether 30 rows, of a second, say the same but for a trembling."""
    return len(rows) == 30 and max(x for x, *_ in rows) - min(x for x, *_ in rows) < 1e-3


def test_encoder_odometry_starts_at_zero_and_does_so_again(ros, simulate):
    simulate('_real_time_factor:=10', '_odometry_source:=encoder', '_publish_odom_tf:=false')
    place = Echo(ros, '/odom/pose/pose/position')
    transforms = ros.start('rostopic', 'echo', '/tf')
    ros.wait_run(r'Subscribers:\s+\* /rostopic', 'rostopic', 'info', '/tf')
    assert place.wait_more(5)[-1] == pytest.approx([0.0, 0.0, 0.0], abs=0.005)
    drive(ros, 0.2)
    place.wait(lambda x, y, z: x > 0.3, 'the robot to drive')
    call(ros, 'reset_world')
    place.wait(lambda x, y, z: x < 0.1, 'the reset')
    rows = place.wait_more(60)[-60:]
    assert [value for row in rows for value in row] == pytest.approx([0.0] * 180, abs=0.005)
    # some 100 messages of odometry, and none of its frame
    assert 'frame_id' not in transforms.output


def test_the_pose_goes_to_tf(ros, simulate):
    simulate()
    transforms = ros.start('rostopic', 'echo', '/tf')
    transforms.wait_output('(?s)frame_id: "odom".*child_frame_id: "base_footprint"')


DRIVE = '''<gazebo><plugin name="drive" filename="libgazebo_ros_diff_drive.so">
  <odometryTopic>my_odom</odometryTopic><odometryFrame>my_odom_frame</odometryFrame>
  <wheelAcceleration>0</wheelAcceleration></plugin></gazebo>'''
LASER = '''<gazebo reference="base_scan"><sensor type="ray" name="lds">
  <update_rate>10</update_rate>
  <ray><scan><horizontal><samples>90</samples></horizontal></scan></ray>
  <plugin name="laser" filename="libgazebo_ros_laser.so"><topicName>my_scan</topicName></plugin>
  </sensor></gazebo>'''


def test_gazebo_tags_are_honoured(ros, simulate):
    node = simulate('_real_time_factor:=5', '_world:=empty', urdf=burger(DRIVE + LASER))
    node.wait_output('simulating')
    scans = ros.start('rostopic', 'echo', '--noarr', '-n', '3', '/my_scan')
    assert scans.wait() == 0
    assert scans.output.count('ranges: "<array type: float32, length: 90>"') == 3
    stamps = [int(seconds) + int(part) * 1e-9 for seconds, part in re.findall(
        r'secs: (\d+)\n *nsecs: +(\d+)', scans.output)]
    assert [b - a for a, b in zip(stamps, stamps[1:])] == pytest.approx([0.1, 0.1])
    topics = ros.run('rostopic', 'list', '-p').split()
    assert {'/my_odom', '/my_scan', '/imu'} <= set(topics)
    assert not {'/odom', '/scan'} & set(topics)
    assert 'my_odom_frame' in ros.run('rostopic', 'echo', '-n', '1', '/my_odom/header')
    # without a ramp a wheel turns as told at once, whatever the slip; 15 rad/s take 0.5 s else
    turning = Echo(ros, '/joint_states/velocity[0]')
    turning.wait_more(5)
    drive(ros, 0.5)
    turning.wait(lambda value: value > 14.5, 'full speed')
    ramp = [value for value, in turning.rows if 1.0 < value < 14.0]
    assert len(ramp) <= 2, ramp


# -- the view

IMAGES = '''
import json
import numpy, rospy
from sensor_msgs.msg import Image

def show(msg):
    pixels = numpy.frombuffer(msg.data, numpy.uint8).reshape(msg.height, msg.width, 3)
    def found(low, high):
        rows, columns = numpy.nonzero(((pixels >= low) & (pixels <= high)).all(axis=2))
        middle = [float(columns.mean()), float(rows.mean())] if len(rows) else None
        return {'share': len(rows) / pixels[..., 0].size, 'middle': middle}
    print(json.dumps({
        'stamp': msg.header.stamp.to_sec(), 'frame': msg.header.frame_id,
        'size': [msg.width, msg.height, msg.step], 'encoding': msg.encoding,
        'green': found((0, 90, 0), (60, 255, 60)), 'white': found((205,) * 3, (255,) * 3),
        'wall': found((20,) * 3, (90,) * 3), 'dark': found((0,) * 3, (130,) * 3)}), flush=True)

rospy.init_node('images', anonymous=True)
rospy.Subscriber('/gazebo/view/image_raw', Image, show, queue_size=1, buff_size=1 << 24)
rospy.spin()
'''


class Images:
    """What the images of the view hold."""

    def __init__(self, ros):
        self._process = ros.start(sys.executable, '-c', IMAGES)

    @property
    def all(self):
        return [json.loads(line) for line in self._process.output.split('\n')[:-1]
                if line.startswith('{')]

    def wait(self, accept=lambda image: True, count=1):
        """Return the newest image once `count` more have come and it is as wanted."""
        goal = len(self.all) + count

        def newest():
            images = self.all
            return images[-1] if len(images) >= goal and accept(images[-1]) else None
        return wait_for(newest, lambda: 'an image; the newest: {}\n{}'.format(
            self.all[-1:], self._process.output[-500:]))

    def close(self):
        self._process.close()


def test_the_view_is_drawn_while_somebody_looks(ros, simulate):
    node = simulate()
    clock = Echo(ros, '/clock/clock')
    since = clock.wait_more(50)[-1][0] * 1e-9
    assert descendants(node.pid) == {}
    images = Images(ros)
    image = images.wait(count=3)
    assert image['stamp'] > since
    clock.wait(lambda now: now * 1e-9 >= image['stamp'], 'the time of the image')
    assert (image['size'], image['encoding']) == ([640, 480, 1920], 'rgb8')
    assert image['frame'] == 'view'
    assert image['green']['share'] > 0.03
    assert image['white']['share'] > 0.0005
    assert image['wall']['share'] > 0.01
    stamps = [each['stamp'] for each in images.all]
    assert stamps == sorted(set(stamps))

    images.close()
    drawer = drawing(node)
    ros.wait_run('Subscribers: None', 'rostopic', 'info', '/gazebo/view/image_raw')

    def idle():
        before = cpu_ticks(drawer)
        clock.wait_more(50)
        return cpu_ticks(drawer) == before
    wait_for(idle, 'an end of the drawing')


def test_from_above_the_robot_is_where_it_is(ros, simulate):
    simulate('_real_time_factor:=5', '_world:=empty')
    images = Images(ros)
    images.wait()
    place = Echo(ros, '/odom/pose/pose/position')
    place.wait_more(1)
    x, y = images.wait(count=2)['dark']['middle']
    # 46 pixels a metre about (0.8, 0), x upwards
    assert (x, y) == pytest.approx((320 + 0.5 * 46.2, 240 + 2.8 * 46.2), abs=4)
    driving = drive(ros, 0.5)
    place.wait(lambda x, y, z: x > 0.0, 'the robot to drive')
    driving.close()
    drive(ros, 0.0)
    x, _, _ = wait_for(lambda: place.rows[-1] if standing(place.rows[-30:]) else None, 'a halt')
    assert images.wait(count=3)['dark']['middle'] == pytest.approx(
        (320 + 0.5 * 46.2, 240 + (0.8 - x) * 46.2), abs=4)


def test_following_keeps_the_robot_in_the_middle(ros, simulate):
    simulate('_real_time_factor:=5', '_world:=empty', '_view:=follow')
    images = Images(ros)
    place = Echo(ros, '/odom/pose/pose/position')
    place.wait_more(1)
    first = images.wait(count=2)
    drive(ros, 0.5)
    place.wait(lambda x, y, z: x > 0.0, 'the robot to drive')
    last = images.wait(count=2)
    for image in (first, last):
        assert image['dark']['share'] > 0.003
        assert image['dark']['middle'] == pytest.approx((320, 240), abs=30)


@pytest.mark.parametrize('busy', [False, True])
def test_the_simulation_outlives_the_process_that_draws(ros, simulate, busy):
    node = simulate('_view_rate:=2', '_real_time_factor:=5')
    clock = Echo(ros, '/clock/clock')
    clock.wait_more(1)
    Images(ros).wait(count=2)
    drawer = drawing(node)      # which has nothing to do for half a second
    if busy:
        os.kill(drawer, signal.SIGSTOP)
        clock.wait_more(400)    # 0.8 s; meanwhile it is asked for an image
    os.kill(drawer, signal.SIGKILL)
    node.wait_output(r'\[WARN\].*no more view: .*; the simulation goes on without')
    clock.wait_more(100)
    assert len(complaints(node)) == 1, node.output
    assert node.interrupt() == 0
    assert 'Traceback' not in node.output


# -- other processes

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
    wait_for(lambda: not any(map(alive, children)), lambda: children)
    assert list(folder.iterdir()) == []
    second.wait_output('simulating 1.0017 kg')
    for topic in ('/clock/clock', '/odom/pose/pose/position'):
        Echo(ros, topic).wait_more(10)
    assert '/gazebo' in ros.run('rosnode', 'list').split()
    assert second.interrupt() == 0


def alive(pid):
    """Return whether a process runs; one that is only waited for does not."""
    try:
        with open('/proc/{}/stat'.format(pid)) as file:
            return file.read().rpartition(')')[2].split()[0] != 'Z'
    except OSError:
        return False


def test_a_subscriber_that_hangs_holds_up_nobody(ros, simulate):
    simulate('_real_time_factor:=0', '_world:=empty', '_odometry_period_s:=0.001',
             '_publish_odom_tf:=false')
    clock = Echo(ros, '/clock/clock')
    stopped = Echo(ros, '/odom/header/stamp')
    stopped.wait_more(10)
    os.kill(stopped.pid, signal.SIGSTOP)
    try:
        since = clock.wait_more(1)[-1][0]
        # 1000 messages of 0.7 kB a second are more than the 40 MB that sockets may hold
        clock.wait(lambda now: now > since + 100e9, '100 s of simulated time')
    finally:
        os.kill(stopped.pid, signal.SIGCONT)

    def gap():
        stamps = [row[0] for row in stopped.rows]
        return max((b - a for a, b in zip(stamps, stamps[1:])), default=0) > 20e9
    # more was sent than sockets hold, of which some is missing and the rest goes on
    wait_for(gap, lambda: stopped.rows[-3:])
    stopped.wait_more(10)


def test_the_real_time_factor_is_told(ros, simulate):
    simulate()
    factor = Echo(ros, '/gazebo/real_time_factor')
    factor.wait(lambda value: 0.5 < value < 1.1, 'real time')
    call(ros, 'pause_physics')
    factor.wait(lambda value: value == 0.0, 'standing still')
