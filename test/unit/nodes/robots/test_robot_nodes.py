"""The arguments of a robot's nodes, and what roslaunch does when one of them ends."""
import os
import sys

import pytest
from roslaunch import nodeprocess, pmon

from img_recog.loading import resources
from img_recog.nodes.robots import robot_nodes
from img_recog.nodes.robots.robot_list import NodeSettings, RobotRow
from img_recog.nodes.robots.robot_nodes import RobotNodes
from img_recog_helpers.pages import launch_arguments
from img_recog_helpers.waiting import wait_for

ROBOT = RobotRow('tb3_1', NodeSettings(
    urdf='/u', colors='/c/colors.yaml', camera='/films/a b.mp4', teleop=False, safe=True), {})


def test_the_nodes_get_all_arguments_of_robot_launch():
    arguments = robot_nodes.arguments(ROBOT, {'camera_frame_id': 'head_camera', 'respawn': True,
                                              'robot_state_publisher': False})
    assert arguments == [
        'name:=tb3_1', 'camera:=/films/a b.mp4', 'colors:=/c/colors.yaml', 'image_width:=640',
        'image_height:=480', 'framerate:=30.0', 'pixel_format:=mjpeg', 'camera_info_url:=',
        'recognition:=true', 'teleop:=false', 'safe:=true', 'camera_frame_id:=head_camera',
        'respawn:=true', 'robot_state_publisher:=false']
    # robot.launch itself sets the others for its parts
    assert {word.split(':=')[0] for word in arguments} == {
        *launch_arguments('robot.launch')} - {'camera_name', 'keys', 'required'}


@pytest.fixture
def nodes(monkeypatch, tmp_path):
    """A function that runs Python code in place of the nodes; without a master."""
    made = []

    def run(*codes, package='img_recog', respawn=True, launched=(), **settings):
        launched = launched if isinstance(launched, list) else []

        class Runner:
            def __init__(self, run_id, config, pmon, sigint_timeout):
                self.monitor = pmon
                launched.extend(config.nodes)
                self.monitor.parameters = set(config.params)

            def launch(self):
                for number, code in enumerate(codes):
                    process = nodeprocess.LocalProcess(
                        None, package, 'node-{}'.format(number), [sys.executable, '-c', code],
                        {**os.environ, 'STARTS': str(tmp_path / 'starts')}, False,
                        respawn=respawn, is_node=False)
                    self.monitor.register(process)
                    assert process.start()
        monkeypatch.setattr(robot_nodes.launch, 'ROSLaunchRunner', Runner)
        made.append(RobotNodes(ROBOT._replace(nodes=NodeSettings(**settings)), {}))
        return made[-1]
    yield run
    for each in made:
        each.wait()


SLEEPS = 'import time; time.sleep(600)'
ENDS = 'import os, signal; open(os.environ["STARTS"], "a").write("1"); {}'


def starts(tmp_path):
    """Return how often the code ENDS was started."""
    path = tmp_path / 'starts'
    return len(path.read_text()) if path.exists() else 0


def test_they_are_interrupted_and_waited_for(nodes):
    running = nodes(SLEEPS, SLEEPS)
    assert not running.has_just_ended()
    running.interrupt()
    running.wait()
    assert running.has_just_ended() and running.has_ended and not running.has_just_ended()


def test_the_nodes_have_no_program_beside_them_and_keep_their_environment(nodes, monkeypatch):
    monkeypatch.delenv('ROSCONSOLE_FORMAT', raising=False)
    launched = []
    nodes(SLEEPS, launched=launched)
    environments = {node.name: dict(node.env_args) for node in launched}
    assert environments.keys() == {'color_extract', 'robot_state_publisher', 'usb_cam',
                                   'turtlebot3_teleop_keyboard'}
    assert {node.launch_prefix for node in launched} == {'setpriv --pdeathsig INT'}
    for environment in environments.values():
        assert environment['IMG_RECOG_RESPAWN'] == '1'
        assert '${node}' in environment['ROSCONSOLE_FORMAT']
    # robots share no keyboard
    assert environments['turtlebot3_teleop_keyboard']['IMG_RECOG_NO_KEYS'] == '1'


def test_a_file_of_colors_that_was_checked_is_not_checked_again_by_its_node(nodes):
    parameters = nodes(SLEEPS, colors=resources.colors())._monitor.parameters
    assert '/tb3_1/color_extract/colors' in parameters
    assert '/tb3_1/color_extract/colors_file' not in parameters


def test_the_signals_are_left_to_the_node(nodes):
    before = robot_nodes.pmon.signal.getsignal(robot_nodes.pmon.signal.SIGINT)
    nodes(SLEEPS)
    assert robot_nodes.pmon.signal.getsignal(robot_nodes.pmon.signal.SIGINT) is before
    assert before is not pmon.rl_signal


@pytest.mark.parametrize('end', [
    'os._exit(70)', 'os._exit(75)', 'os._exit(77)', 'os.kill(os.getpid(), signal.SIGKILL)'])
def test_a_node_that_did_not_want_to_end_is_started_again(nodes, tmp_path, end):
    running = nodes(ENDS.format(end))
    wait_for(lambda: starts(tmp_path) > 2, 'the third start')
    assert not running.has_just_ended()


def test_a_program_of_another_package_is_started_again_whatever_its_code_is(nodes, tmp_path):
    nodes(ENDS.format('os._exit(3)'), package='robot_state_publisher')
    wait_for(lambda: starts(tmp_path) > 2, 'the third start')


@pytest.mark.parametrize('code, respawn', [(0, True), (1, True), (76, True), (70, False)])
def test_a_node_that_refuses_or_is_done_is_not_started_again(nodes, tmp_path, code, respawn):
    running = nodes(ENDS.format('os._exit({})'.format(code)), respawn=respawn)
    wait_for(running.has_just_ended, 'the end')
    assert starts(tmp_path) == 1


def test_a_parameter_that_is_not_allowed_ends_all_nodes_of_the_robot(nodes, tmp_path):
    running, other = nodes(SLEEPS, ENDS.format('os._exit(78)')), nodes(SLEEPS)
    wait_for(running.has_just_ended, 'the end')
    assert starts(tmp_path) == 1 and not other.has_just_ended()


def test_nodes_that_cannot_start_leave_no_others(nodes, monkeypatch):
    threads = []

    class Runner:
        def __init__(self, run_id, config, pmon, sigint_timeout):
            threads.append(pmon)

        def launch(self):
            raise pmon.FatalProcessLaunch('no such node')
    monkeypatch.setattr(robot_nodes.launch, 'ROSLaunchRunner', Runner)
    with pytest.raises(robot_nodes.launch.RLException, match='no such node'):
        RobotNodes(ROBOT._replace(nodes=NodeSettings()), {})
    assert not threads[0].is_alive()
