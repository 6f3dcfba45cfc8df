"""The command that starts the nodes of a robot, and what happens when they end."""
import os
import sys
import time
from xml.etree import ElementTree

import pytest

from img_recog.nodes.robots import robot_nodes
from img_recog.nodes.robots.robot_list import NodeSettings, Robot
from img_recog.nodes.robots.robot_nodes import RobotNodes
from img_recog_testing.pages import ROOT
from img_recog_testing.waiting import DEADLINE_S, wait_for

ROBOT = Robot('tb3_1', NodeSettings(urdf='/u', colors='/c/colors.yaml', camera='/films/a b.mp4',
                                    teleop=False, safe=True), {})


def test_the_command_has_all_arguments():
    words = robot_nodes.command(ROBOT, {'camera_frame_id': 'head_camera', 'respawn': True,
                                        'robot_state_publisher': False})
    assert words[:4] == ['setpriv', '--pdeathsig', 'INT', 'roslaunch']
    assert words[words.index('img_recog'):] == [
        'img_recog', 'robot.launch', 'name:=tb3_1', 'camera:=/films/a b.mp4',
        'colors:=/c/colors.yaml', 'image_width:=640', 'image_height:=480', 'framerate:=30.0',
        'pixel_format:=mjpeg', 'camera_info_url:=', 'recognition:=true', 'teleop:=false',
        'safe:=true', 'camera_frame_id:=head_camera', 'respawn:=true',
        'robot_state_publisher:=false']


def test_robot_launch_has_these_arguments():
    launch = ElementTree.parse(os.path.join(ROOT, 'launch', 'robot.launch')).getroot()
    names = {arg.get('name') for arg in launch.iterfind('arg[@doc]')}
    words = robot_nodes.command(ROBOT, {'camera_frame_id': 'head_camera', 'respawn': True,
                                        'robot_state_publisher': False})
    assert {word.split(':=')[0] for word in words if ':=' in word} == names


@pytest.fixture
def nodes(monkeypatch):
    """A function that runs Python code in place of the nodes."""
    made = []

    def run(code):
        monkeypatch.setattr(robot_nodes, 'command', lambda *_: [sys.executable, '-c', code])
        made.append(RobotNodes(ROBOT, {}))
        return made[-1]
    yield run
    for each in made:
        each.interrupt()
        each.wait()


def test_they_are_interrupted_and_waited_for(nodes):
    running = nodes('import time; time.sleep(600)')
    assert running.check() is None
    running.interrupt()
    running.wait()
    assert running.check() is None


def test_nodes_that_end_at_once_are_not_started_again(nodes, monkeypatch):
    monkeypatch.setattr(robot_nodes, '_LONG_LIFE_S', 10 * DEADLINE_S)   # a start may take long
    running = nodes('import sys; sys.exit(3)')
    wait_for(running._process.poll, 'the end')
    assert running.check() == 'its nodes have ended with exit code 3, and are not started again'
    assert running.has_ended
    assert running.check() is None


def test_nodes_whose_roslaunch_was_killed_are_started_again(nodes):
    running = nodes('import os, signal; os.kill(os.getpid(), signal.SIGKILL)')
    wait_for(running._process.poll, 'the end')
    assert running.check() == 'its nodes have ended with exit code -9, and are started again'
    assert not running.has_ended


def test_nodes_that_have_lived_are_started_again(nodes, monkeypatch):
    running = nodes('import sys; sys.exit(4)')
    wait_for(running._process.poll, 'the end')
    monkeypatch.setattr(running, '_started_s', time.monotonic() - 60)
    assert running.check() == 'its nodes have ended with exit code 4, and are started again'
    assert running._process is not None
