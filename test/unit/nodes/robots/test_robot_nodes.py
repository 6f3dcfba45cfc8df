"""The command that starts the nodes of a robot, and what happens when they end."""
import sys

import pytest

from img_recog.nodes.robots import robot_nodes
from img_recog.nodes.robots.robot_list import NodeSettings, RobotRow
from img_recog.nodes.robots.robot_nodes import RobotNodes
from img_recog_helpers.pages import launch_arguments
from img_recog_helpers.waiting import DEADLINE_S, wait_for

ROBOT = RobotRow('tb3_1', NodeSettings(
    urdf='/u', colors='/c/colors.yaml', camera='/films/a b.mp4', teleop=False, safe=True), {})


def test_the_command_has_all_arguments_of_robot_launch():
    words = robot_nodes.command(ROBOT, {'camera_frame_id': 'head_camera', 'respawn': True,
                                        'robot_state_publisher': False})
    assert words[:4] == ['setpriv', '--pdeathsig', 'INT', 'roslaunch']
    arguments = words[words.index('robot.launch') + 1:]
    assert arguments == [
        'name:=tb3_1', 'camera:=/films/a b.mp4', 'colors:=/c/colors.yaml', 'image_width:=640',
        'image_height:=480', 'framerate:=30.0', 'pixel_format:=mjpeg', 'camera_info_url:=',
        'recognition:=true', 'teleop:=false', 'safe:=true', 'camera_frame_id:=head_camera',
        'respawn:=true', 'robot_state_publisher:=false']
    # robot.launch itself sets the other two for its parts
    assert {word.split(':=')[0] for word in arguments} == {
        *launch_arguments('robot.launch')} - {'camera_name', 'required'}


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


@pytest.mark.parametrize('code, long_life_s, line', [
    ('import sys; sys.exit(3)', 10 * DEADLINE_S,        # a start may take long
     'its nodes have ended with exit code 3, and are not started again'),
    ('import os, signal; os.kill(os.getpid(), signal.SIGKILL)', 10 * DEADLINE_S,
     'its nodes have ended with exit code -9, and are started again'),
    ('import sys; sys.exit(4)', 0.0,
     'its nodes have ended with exit code 4, and are started again')])
def test_nodes_are_started_again_unless_they_end_at_once(nodes, monkeypatch, code, long_life_s,
                                                         line):
    monkeypatch.setattr(robot_nodes, 'LONG_LIFE_S', long_life_s)
    running = nodes(code)
    assert wait_for(running.check, 'the end') == line
    assert running.has_ended == ('not' in line)
    if running.has_ended:
        assert running.check() is None
