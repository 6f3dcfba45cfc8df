"""The node robots: several robots in one world, each with its nodes in its namespace.

Serves: ~reload (std_srvs/Trigger): reads the list of robots again; starts those that are new or
have changed, and ends those that are not in it any more. The message has a line for each robot
that cannot be: NAME: REASON.
Calls the service of gazebo that updates the robots. Sets gazebo/robots, and for each robot
NAME/robot_description.
Reads: the fields of ManagerSettings and NodeSettings as private parameters.
"""
import contextlib
import dataclasses
import functools
import math
import time
from dataclasses import dataclass
from typing import Dict, Iterable, List

import rospy
from roslaunch import RLException
from std_srvs.srv import Trigger, TriggerRequest, TriggerResponse

from img_recog import files
from img_recog.camera_arguments import (CAMERA_INFO_TOPIC, CAMERA_TOPIC, FRAME, ROBOT,
                                        ROBOT_LINK)
from img_recog.errors import UserError, one_line
from img_recog.loading import resources, robot_file
from img_recog.nodes.robots import robot_list, robot_nodes
from img_recog.nodes.robots.robot_list import NodeSettings, RobotRow
from img_recog.nodes.robots.robot_nodes import RobotNodes
from img_recog.recognition import parameter_file
from img_recog.ros import lifecycle, parameters
from img_recog.ros.queues import CallQueue
from img_recog.ros.throttle import ThrottledWarning
from img_recog.settings import Settings, not_empty, setting

_PERIOD_S = 0.5
_SERVICE_TIMEOUT_S = 1.0
_PATIENCE_S = 10.0          # with a simulator that starts
_RELOAD_TIMEOUT_S = 600.0
_SIMULATED = 'gazebo/robots'
_UPDATE = 'gazebo/update_robots'
# what must not outlive a robot, in its namespace: also those of the nodes of robot.launch
_PARAMETERS = ('robot_description', 'color_extract', 'robot_state_publisher',
               'turtlebot3_teleop_keyboard', 'usb_cam')


@dataclass(frozen=True)
class ManagerSettings(Settings):
    """Which robots there are.

    robots: a number, or the path of a YAML file. simulator: whether the robots are simulated;
    else only their nodes are started. respawn: whether a node that was killed is started again.
    robot_camera_frame: the link that carries the camera of camera:=robot; camera_frame_id: frame
    of the images, without the prefix of a robot.
    """

    robots: str = setting('1', not_empty())
    simulator: bool = setting(True)
    respawn: bool = setting(True)
    robot_camera_frame: str = setting(ROBOT_LINK, not_empty())
    camera_frame_id: str = setting(FRAME, not_empty())

    def __post_init__(self):
        if type(self.robots) is int:        # rosrun makes a number of _robots:=4
            object.__setattr__(self, 'robots', str(self.robots))
        super().__post_init__()


class RobotsNode:
    """Keeps the robots those of the list; all in the main thread."""

    def __init__(self) -> None:
        self._settings = parameters.read(ManagerSettings)
        self._defaults = dataclasses.asdict(parameters.read(NodeSettings))
        self._defaults['camera'] = robot_list.camera(self._defaults['camera'],
                                                     files.user_folders()[0])
        self._defaults['urdf'] = self._defaults['urdf'] or resources.burger()
        self._defaults['colors'] = self._defaults['colors'] or resources.colors()
        parameters.warn_of_unknown(ManagerSettings, NodeSettings)
        self._running: Dict[str, RobotNodes] = {}
        self._calls, self._warn = CallQueue(), ThrottledWarning()

    def spin(self) -> None:
        """Run the robots until the node is shut down."""
        try:
            self._update()
            rospy.Service('~reload', Trigger, self._reload)
            while not rospy.is_shutdown():
                self._calls.process(_PERIOD_S)
                self._check()
        finally:
            self._stop(list(self._running))

    def _reload(self, _: TriggerRequest) -> TriggerResponse:
        try:
            problems = self._calls.call(self._update, _RELOAD_TIMEOUT_S)
        except UserError as error:
            return TriggerResponse(False, one_line(error))
        return TriggerResponse(not problems, '\n'.join(_lines(problems)))

    def _update(self) -> Dict[str, str]:
        """Make the robots those of the list; return why others cannot be, by name.

        Raises RobotListError when there is no list; then nothing changes.
        """
        listed = robot_list.read_robots(files.find_user_path(self._settings.robots),
                                        self._defaults, resources.find)
        problems = dict(listed.problems)
        wanted: Dict[str, RobotRow] = {}
        read_urdf = functools.lru_cache(maxsize=None)(robot_file.read)  # xacro takes a second
        for row in listed.robots:
            try:
                wanted[row.name] = row._replace(
                    description=read_urdf(row.nodes.urdf),
                    colors=parameter_file.load(row.nodes.colors).values
                    if row.nodes.recognition else None)
            except UserError as error:
                problems[row.name] = one_line(error)
        # one that runs and has an error in the list now goes on as it is
        self._stop([name for name, nodes in self._running.items() if name not in problems and (
            nodes.robot != wanted.get(name) or nodes.has_ended)])
        _log(problems)
        new = {name: each for name, each in wanted.items() if name not in self._running}
        if self._settings.simulator:
            problems.update(self._simulate(new))
        for name, robot in new.items():
            if name not in problems and not rospy.is_shutdown():
                try:
                    self._running[name] = RobotNodes(robot, {
                        'camera_frame_id': self._settings.camera_frame_id,
                        'respawn': self._settings.respawn,
                        'robot_state_publisher': self._settings.simulator})
                except (OSError, ValueError, RLException) as error:
                    problems[name] = one_line(error)
                    _log({name: problems[name]})
        if not rospy.is_shutdown():
            rospy.loginfo('%d robots are running%s', len(self._running),
                          ', {} not started'.format(len(problems)) if problems else '')
        return problems

    def _robots(self) -> Dict[str, RobotRow]:
        return {name: nodes.robot for name, nodes in self._running.items()}

    def _simulate(self, new: Dict[str, RobotRow]) -> Dict[str, str]:
        """Have the simulator add and remove robots; return why it refuses some, logged."""
        taken = {name: 'there is a parameter {}; give the robot another name'.format(
            rospy.resolve_name(name)) for name in new if not isinstance(
                parameters.value(name), (dict, type(None)))}
        _log(taken)
        robots = {**self._robots(),
                  **{name: each for name, each in new.items() if name not in taken}}
        self._set_parameters(robots)
        update = rospy.ServiceProxy(_UPDATE, Trigger)
        warn_s = time.monotonic() + _PATIENCE_S
        while not rospy.is_shutdown():
            try:
                update.wait_for_service(_SERVICE_TIMEOUT_S)
                return {**taken, **self._refused(update(), robots)}
            except rospy.ServiceException as error:
                self._warn('%s fails, and is called again: %s', rospy.resolve_name(_UPDATE),
                           one_line(error))
                time.sleep(_PERIOD_S)
            except rospy.ROSException:
                if time.monotonic() > warn_s:
                    warn_s = math.inf
                    rospy.logwarn('waiting for the service %s: is the simulator running?',
                                  rospy.resolve_name(_UPDATE))
        return taken

    def _refused(self, answer: TriggerResponse, names: Iterable[str]) -> Dict[str, str]:
        """Return why the simulator refuses some new robots, and forget their parameters.

        It answers with a line NAME: REASON for each, or with one about no robot.
        """
        if answer.success:
            return {}
        found = dict(line.partition(': ')[::2] for line in answer.message.splitlines())
        if not set(found).issubset(names):
            found = dict.fromkeys(sorted(names), answer.message)
        refused = {name: reason for name, reason in found.items() if name not in self._running}
        for name in refused:
            with contextlib.suppress(KeyError):
                rospy.delete_param('{}/{}'.format(_SIMULATED, name))
        return refused

    def _set_parameters(self, robots: Dict[str, RobotRow]) -> None:
        for name, robot in robots.items():
            rospy.set_param(name + '/robot_description', robot.description)
        rospy.set_param(_SIMULATED, {name: self._parameters_of(robot)
                                     for name, robot in robots.items()})

    def _parameters_of(self, robot: RobotRow) -> dict:
        """Return the parameters of a robot in the simulator."""
        nodes = robot.nodes
        if nodes.camera != ROBOT:
            return robot.simulation
        return {'camera_frame': self._settings.robot_camera_frame,
                'camera_optical_frame': self._settings.camera_frame_id,
                'camera_image_topic': CAMERA_TOPIC, 'camera_info_topic': CAMERA_INFO_TOPIC,
                'camera_width': nodes.image_width, 'camera_height': nodes.image_height,
                'camera_rate': nodes.framerate,
                **robot.simulation}

    def _stop(self, names: List[str]) -> None:
        """End the nodes of robots, all at a time, and forget the robots."""
        stopped = {name: self._running.pop(name) for name in names}
        for nodes in stopped.values():
            nodes.interrupt()
        for name, nodes in stopped.items():
            nodes.wait()
            for parameter in _PARAMETERS:
                with contextlib.suppress(OSError, KeyError):    # no master, or no parameter
                    rospy.delete_param('{}/{}'.format(name, parameter))

    def _check(self) -> None:
        """Log which robots have no nodes any more; tell a new master what the simulator reads."""
        with contextlib.suppress(OSError):      # there is no master
            if self._settings.simulator and not rospy.has_param(_SIMULATED):
                self._set_parameters(self._robots())
        for name, nodes in self._running.items():
            if nodes.has_just_ended():
                rospy.logerr('robot %s: its nodes have ended, and are not started again; call %s '
                             'to start them', name, rospy.resolve_name('~reload'))


def _lines(problems: Dict[str, str]) -> List[str]:
    return ['{}: {}'.format(name, reason) for name, reason in problems.items()]


def _log(problems: Dict[str, str]) -> None:
    for line in _lines(problems):
        rospy.logerr('not started: %s', line)


def main() -> int:
    """Run the node; return its exit code."""
    return lifecycle.run('robots', lambda: RobotsNode().spin(),
                         {'~': (ManagerSettings, NodeSettings)},
                         end_limit_s=robot_nodes.END_LIMIT_S)
