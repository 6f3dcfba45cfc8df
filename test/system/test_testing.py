"""img_recog.testing as tests of another package use it: by pytest, and in a rostest."""
import itertools
import os
import shutil
import signal
import sys
import xml.etree.ElementTree as ET

import av
import pytest

from img_recog_helpers import process_table
from img_recog_helpers.processes import Ros
from img_recog_helpers.waiting import wait_for

PACKAGE = '''<package format="2"><name>{}</name><version>0.0.0</version><license>none</license>
<description>of a test</description><maintainer email="a@b.c">a</maintainer></package>'''
LAUNCH = '''<launch><arg name="type" default="driver.py"/>
<node name="driver" pkg="my_driver" type="$(arg type)"/></launch>'''
DRIVER = '''#!{}
import rospy
from geometry_msgs.msg import Twist, Vector3
from sensor_msgs.msg import Image
from std_msgs.msg import Header

rospy.init_node('driver')
velocity = rospy.Publisher('cmd_vel', Twist, queue_size=1)
rospy.Publisher('silent', Header, queue_size=1)
rospy.Subscriber('usb_cam/image_raw', Image, lambda msg: velocity.publish(
    Twist(Vector3(0.2, 0, 0), Vector3(0, 0, msg.data[0] / 1000))), buff_size=1 << 20)
rospy.spin()
'''.format(sys.executable)
BROKEN = '''#!{}
raise ValueError('no wheels')
'''.format(sys.executable)
# of the first, a mask shows the whole image, of the second, nothing
COLORS = 'colors: [all, nothing]\n' + ''.join(
    '{}_{}_{}: {}\n'.format(color, part, side, bound)
    for color, bounds in (('all', (0, 180, 0, 255, 0, 255)), ('nothing', (90, 90, 255, 255, 0, 0)))
    for (part, side), bound in zip(itertools.product(
        ('hue', 'saturation', 'value'), ('min', 'max')), bounds))
DRIVE = "launch=('my_driver', 'drive.launch'), lockstep='cmd_vel', image_width=64, image_height=48"
# nothing is drawn
BY_SCAN = "camera='none', world='empty', lockstep_sensors='scan', lockstep="


@pytest.fixture(scope='module')
def workspace(tmp_path_factory):
    """The folder of a package, and a function that starts a program which finds it."""
    package = tmp_path_factory.mktemp('workspace') / 'my_driver'
    package.mkdir()
    for name, text in (('package.xml', PACKAGE.format('my_driver')), ('drive.launch', LAUNCH),
                       ('driver.py', DRIVER), ('broken.py', BROKEN), ('colors.yaml', COLORS),
                       ('conftest.py', "pytest_plugins = ['img_recog.testing.fixtures']\n")):
        (package / name).write_text(text)
        (package / name).chmod(0o755)
    with Ros(package.parent) as ros:
        env = dict(ros.env, ROS_PACKAGE_PATH='{}:{}'.format(
            package, os.environ['ROS_PACKAGE_PATH']))
        del env['ROS_MASTER_URI']

        def start(*command):
            return ros.start(*command, env=env, cwd=str(package))
        start.marker = ros.marker
        yield package, start


def run_pytest(workspace, text):
    """Run a test file; return the outcome of each test: its message, or '' if it has passed."""
    package, start = workspace
    (package / 'test_it.py').write_text(text)
    process = start(sys.executable, '-m', 'pytest', '-p', 'no:cacheprovider',
                    '--junitxml=results/junit.xml', 'test_it.py')
    process.wait()
    results = package / 'results' / 'junit.xml'
    assert results.exists(), process.output
    return {case.get('name'): ''.join(each.get('message') for each in case)
            for case in ET.parse(str(results)).iter('testcase')}


@pytest.fixture(scope='module')
def failed(workspace):
    """The outcomes of tests that fail, and a copy of the folder with what is kept of them."""
    outcomes = run_pytest(workspace, '''
import os, pytest
from img_recog.testing import Simulation
from std_msgs.msg import Header, String

@pytest.mark.parametrize('arguments', [
    dict(launch='no.launch'), dict(launch=('my_driver', 'no.launch')),
    dict(launch=('no_package', 'a.launch')), dict(launch=3), dict(robot='no.urdf'),
    dict(no_argument=1), dict(launch=('my_driver', 'drive.launch', {{'no_argument': 1}})),
    dict(launch=('my_driver', 'drive.launch', {{'type': 'broken.py'}}), camera='none',
         simulator=False),
    dict(launch=('my_driver', 'drive.launch', {{'type': 'none.py'}}), camera='none',
         simulator=False),
    dict(camera='none', world='no_world')])
def test_start(simulation, arguments):
    simulation(**arguments)

def test_outside():
    Simulation().step(0.1)

def test_it_stands(simulation):
    sim = simulation({by_scan}'/nobody', wall_timeout_s=7.0)
    # caught, so that no picture of it is drawn
    with pytest.raises(AssertionError, match='has not passed for 7 s on the clock: '
                       'simulation paused: waiting for a publisher of /nobody'):
        sim.step(0.1)

def test_does_not_answer(simulation):
    simulation({by_scan}'/silent', launch=('my_driver', 'drive.launch'),
               lockstep_timeout=0.5).step(1.0)

def test_other(simulation):
    sim = simulation({drive}, recognition=True, colors=os.path.abspath('colors.yaml'))
    for call, words in ((lambda: sim.step(0), 'got 0 s'), (lambda: sim.step(0.0005), 'not divide'),
                        (lambda: sim.pose('a'), "give one of ''"),
                        (lambda: sim.message('cmd_vel', String), 'has the type geometry_msgs/Tw'),
                        (lambda: Simulation().start(), 'another Simulation runs')):
        with pytest.raises(Exception, match=words):
            call()
    with pytest.raises(AssertionError, match='in 2 s of simulated time: /driver has sent none'):
        sim.message('silent', Header)
    sim.wait_until(lambda: sim.pose().x > 9.0, timeout_s=0.2)
'''.format(drive=DRIVE, by_scan=BY_SCAN))
    kept = workspace[0] / 'failed'
    shutil.copytree(str(workspace[0] / 'results'), str(kept))
    return outcomes, kept


def test_what_is_wrong_is_said(failed):
    outcomes, kept = failed
    for name, *words in (
            ('start[arguments0]', 'there is no file /', 'no.launch'),
            ('start[arguments1]', 'no.launch', 'my_driver'),
            ('start[arguments2]', 'no_package'),
            ('start[arguments3]', 'launch: got 3'),
            ('start[arguments4]', 'robot: there is no file'),
            ('start[arguments5]', 'unused args [no_argument]'),
            ('start[arguments6]', 'unused args [no_argument]', 'drive.launch'),
            ('start[arguments7]', 'the node driver has ended: ValueError: no wheels'),
            ('start[arguments8]', 'cannot launch node of type [my_driver/none.py]'),
            ('start[arguments9]', 'the node gazebo has ended: ', 'no_world'),
            ('outside', 'the simulation does not run'),
            ('does_not_answer', 'the node gazebo has ended: lockstep: no answer in 0.5 s'),
            ('other', 'not within 0.2 s of simulated time: sim.wait_until(lambda: sim.pose().x > '
             '9.0', '/odom: x -', 'the last lines of the nodes:')):
        for word in words:
            assert word in outcomes.get('test_' + name, ''), outcomes
    assert outcomes.get('test_it_stands') == '', outcomes
    assert sorted(path.name for path in kept.glob('test_other*')) == [
        'test_other.above.png', 'test_other.camera.png', 'test_other.log', 'test_other.mp4']
    shown = (kept / 'junit.xml').read_text()
    assert 'img_recog/testing/' not in shown and 'During handling' not in shown, shown


def test_the_film_shows_the_colors_of_the_test(failed):
    with av.open(str(failed[1] / 'test_other.mp4')) as film:
        *_, last = (frame.to_ndarray(format='gray') for frame in film.decode(video=0))
    # black is what a mask leaves out: both masks with the colors of the article, else none
    assert 0.02 < (last < 16).mean() < 0.05


def test_each_simulation_of_a_process_drives_the_same_path(workspace, failed):
    """And what was kept of tests is removed when they pass, but not what others have written."""
    kept = workspace[0] / 'results'
    (kept / 'test_mine.log').write_text('')
    outcomes = run_pytest(workspace, '''
import rospy

def drive(simulation, period_s, name):
    sim = simulation({drive}, name=name)
    assert sim.time_s == 0.0 and rospy.get_param('/gazebo/world') == 'color_posts'
    assert sim.step(0.5) == 0.5
    picture = sim.image()
    assert picture.pixels.shape == (48, 64, 3) and abs(picture.time_s - 0.495) < 1e-6
    sim.wait_until(lambda: sim.pose().x > -1.9, period_s=period_s)
    sim.step(2.0 - sim.time_s)
    return sim.pose()

def test_path(simulation):
    first, second = drive(simulation, 0.1, 'test_other'), drive(simulation, 0.25, 'test_mine')
    assert first == second and abs(first.time_s - 1.98) < 1e-6 and first.yaw != 0.0

def test_parameters():
    assert rospy.get_param('/gazebo', None) is None
'''.format(drive=DRIVE))
    assert outcomes == dict.fromkeys(['test_path', 'test_parameters'], '')
    assert not [*kept.glob('test_other*')] and (kept / 'test_mine.log').exists()


def test_in_a_rostest(workspace):
    package, start = workspace
    (package / 'drive_test.py').write_text('''#!{python}
import time, unittest, rostest
from img_recog.testing import Simulation

class Drive(unittest.TestCase):
    def test_drives(self):
        with Simulation({drive}) as sim:
            sim.wait_until(lambda: sim.pose().x > -1.9)

    def test_fails_at_the_end_without_a_camera_and_node(self):
        with Simulation(camera='none', world='empty', x_pos=1.0, real_time_factor=5,
                        name='failed') as sim:
            pose = sim.pose()
            assert abs(pose.x - 1.0) < 1e-3 and sim.time_s == 0.1 and pose.time_s == 0.099
            with self.assertRaisesRegex(AssertionError, 'no message on /usb_cam/image_raw in 2 s '
                                        'of simulated time: nobody publishes it'):
                sim.image()
            began_s = time.monotonic()
            sim.step(1.0)
            assert time.monotonic() - began_s > 0.15
            self.fail('as it should')

rostest.rosrun('my_driver', 'drive_test', Drive)
'''.format(python=sys.executable, drive=DRIVE))
    (package / 'drive_test.py').chmod(0o755)
    (package / 'drive.test').write_text(
        # the nodes of a simulation are not in the namespace of the test
        '<launch><group ns="lab"><test test-name="drive_test" pkg="my_driver" '
        'type="drive_test.py" time-limit="300"/></group></launch>')
    process = start('rostest', '--results-base-dir', package, '--text', 'drive.test')
    process.wait()
    assert 'as it should' in process.output, process.output
    assert 'FAILED (failures=1)' in process.output, process.output
    assert list(package.rglob('failed.log')), process.output


@pytest.mark.parametrize('signum', [signal.SIGINT, signal.SIGKILL])
def test_nothing_is_left(workspace, signum):
    package, start = workspace
    (package / 'test_it.py').write_text('''
def test_endless(simulation):
    sim = simulation(launch=('my_driver', 'drive.launch'), camera='none', world='empty')
    sim.step(0.1)
    open('begun', 'w').close()
    while sim.step(0.1):
        pass
''')
    (package / 'begun').unlink(missing_ok=True)
    process = start(sys.executable, '-m', 'pytest', '-p', 'no:cacheprovider', 'test_it.py')
    wait_for((package / 'begun').exists, lambda: process.output)
    process.send_signal(signum)
    process.wait()
    wait_for(lambda: not process_table.marked(start.marker), 'the end of all nodes')
