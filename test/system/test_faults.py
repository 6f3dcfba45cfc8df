"""The demo after the death of a part: the robot stops, and the chain works again."""
import os
import re
import signal

import pytest

from img_recog.ros.transport.switch import is_plain
from img_recog_helpers.processes import Ros
from img_recog_helpers.process_table import descendants, is_alive
from img_recog_helpers.waiting import wait_for

# with plain rospy, nodes do not know whether there is a master
WATCHED = pytest.mark.skipif(is_plain('registration'), reason='plain rospy')
PROGRAMS = {'usb_cam': 'usb_cam_node.py', 'color_extract': 'color_img_recog.py',
            'gazebo': 'pybullet_sim.py', 'turtlebot3_teleop_keyboard': 'teleop_key.py'}


class Demo:
    """The demo with a master that can be killed on its own."""

    def __init__(self, ros):
        self.ros = ros
        ros.start_master()
        # the cards come twice as often as at the usual rate
        self.process = ros.demo('world:=empty', 'framerate:=60', 'image_width:=160',
                                'image_height:=120')
        self.wait('the robot drives forward')

    def node(self, name):
        """Return the process id of a node."""
        def pids():
            return [pid for pid, line in descendants(self.process.pid).items()
                    if PROGRAMS[name] in line and 'respawn.py' not in line]
        return wait_for(pids, name)[0]

    @property
    def output(self):
        return self.process.output

    def wait(self, pattern, after=0, count=1):
        """Wait until a pattern is found `count` times in the output after a position."""
        wait_for(lambda: len(re.findall(pattern, self.output[after:])) >= count,
                 lambda: '{} of {!r} in:\n{}'.format(count, pattern, self.output[after:]))

    def wait_chain(self, after):
        """Wait until the recognition moves the robot, and it stands again in between."""
        self.wait('(?s)the robot stands.*the robot drives', after)


@pytest.fixture(scope='module')
def demo(tmp_path_factory):
    """One demo for all tests of this module: each leaves it running."""
    with Ros(tmp_path_factory.mktemp('faults')) as ros:
        yield Demo(ros)


def test_robot_stands_while_recognition_and_teleop_give_no_sign(demo):
    # first the teleop, whose zeros would stop the robot
    pids = [demo.node('turtlebot3_teleop_keyboard'), demo.node('color_extract')]
    warning = (r'\[WARN\].*no command on cmd_vel for 0.5 s of simulated time: the robot is '
               'stopped')
    # the last command may be one of the teleop's zeros, which are 0.1 s apart: then try again
    for _ in range(10):
        demo.wait('the robot drives', len(demo.output))     # for a second
        after = len(demo.output)
        for pid in pids:
            os.kill(pid, signal.SIGSTOP)
        try:
            demo.wait('the robot stands', after)
        finally:
            for pid in pids:
                os.kill(pid, signal.SIGCONT)
        if re.search(warning, demo.output[after:]):
            break
    assert re.search(warning, demo.output[after:]), demo.output[after:]
    demo.wait_chain(after)


@pytest.mark.parametrize('name', list(PROGRAMS))
def test_killed_node_comes_back(demo, name):
    pid, after = demo.node(name), len(demo.output)
    os.kill(pid, signal.SIGKILL)
    demo.wait(r'\[respawn\] {}: killed by SIGKILL, started again'.format(name), after)
    if name == 'gazebo':
        demo.wait('the robot is at the start: x -2.00 m, y -0.50 m', after)
    demo.wait_chain(after)
    assert demo.node(name) != pid
    assert 'Traceback' not in demo.output[after:] and 'has died' not in demo.output[after:]


def test_node_that_was_shut_down_from_outside_comes_back(demo):
    pid, after = demo.node('usb_cam'), len(demo.output)
    demo.ros.run('rosnode', 'kill', '/usb_cam')
    demo.wait(r'usb_cam: shut down from outside, started again', after)
    wait_for(lambda: demo.node('usb_cam') != pid, 'another usb_cam')
    demo.wait_chain(after)


@WATCHED
def test_new_master_knows_nodes_and_parameters(demo):
    # the nodes read their parameters once a second, to keep them
    demo.wait_chain(len(demo.output))
    before = demo.ros.parameter('/usb_cam')
    after = len(demo.output)
    demo.ros.kill_master()
    # the connection is refused, or ends if a node was just asking
    demo.wait(r'the master at \S+ does not answer: ', after, len(PROGRAMS))
    demo.ros.start_master()
    demo.wait(r'a master answers at \S+: registered again', after, len(PROGRAMS))
    assert set(demo.ros.run('rosnode', 'list').split()) >= {'/' + name for name in PROGRAMS}
    assert demo.ros.parameter('/usb_cam') == before and before['video_device'] == 'synthetic'
    assert demo.ros.parameter('/use_sim_time') is True
    assert '<robot' in demo.ros.parameter('/robot_description')
    assert demo.ros.run('rosservice', 'call', '/gazebo/unpause_physics').strip() == ''
    # a camera that starts now finds its parameters, and is found by the recognition
    pid = demo.node('usb_cam')
    back = len(demo.output)
    os.kill(pid, signal.SIGKILL)
    demo.wait('camera: synthetic scene', back)
    demo.wait_chain(len(demo.output))
    assert 'Traceback' not in demo.output[after:]


@WATCHED
def test_nodes_end_while_the_master_does_not_answer(demo):
    pids = [demo.node(name) for name in PROGRAMS]
    demo.ros.core.send_signal(signal.SIGSTOP)       # it accepts connections, and that is all
    try:
        for pid in pids:
            os.kill(pid, signal.SIGINT)
        wait_for(lambda: not any(map(is_alive, pids)), lambda: 'the end of {} in:\n{}'.format(
            [pid for pid in pids if is_alive(pid)], demo.output), 30.0)
    finally:
        demo.ros.core.send_signal(signal.SIGCONT)
