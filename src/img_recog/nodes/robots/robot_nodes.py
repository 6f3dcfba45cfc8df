"""Runs the nodes of a robot."""
import dataclasses
import os
from typing import Any, Dict, List, Mapping, Optional

import roslib
from roslaunch import config, launch, pmon, rlutil, xmlloader

from img_recog.loading import resources
from img_recog.nodes.robots.robot_list import RobotRow
from img_recog.recognition.parameter_file import COLORS_FILE
from img_recog.ros import lifecycle

# roslaunch waits 15 s for the end of this node, which sends SIGTERM to a node of a robot after 8 s
END_LIMIT_S, _SIGINT_TIMEOUT_S = 12.0, 8.0
# a node that has died before in the last 10 s is started again after a growing delay
_OFTEN_S, _FIRST_DELAY_S, _MAX_DELAY_S = 10.0, 0.5, 5.0
_STARTED_AGAIN = lifecycle.EXIT_UNEXPECTED, lifecycle.EXIT_NO_MASTER, lifecycle.EXIT_SHUT_DOWN
# the lines of the nodes of different robots can be told apart
_LOG_FORMAT = 'ROSCONSOLE_FORMAT', '[${severity}] [${time}] ${node}: ${message}'


class RobotNodes:
    """robot.launch of a robot, run by roslaunch's modules. To be used in the main thread.

    robot: whose nodes they are. has_ended: whether all have ended and are not started again.
    """

    def __init__(self, robot: RobotRow, values: Mapping[str, Any]):
        """Start the nodes of a robot.

        Args:
            robot: Robot of the list.
            values: Arguments of robot.launch that are not in `robot`.

        Raises: RLException or OSError.
        """
        self.robot, self.has_ended = robot, False
        self._died_s: Dict[str, float] = {}
        launched = config.ROSLaunchConfig()
        xmlloader.XmlLoader().load(resources.find('package://img_recog/launch/robot.launch'),
                                   launched, argv=arguments(robot, values), verbose=False)
        # the node robots has checked the file already
        launched.params.pop('/{}/color_extract/{}'.format(robot.name, COLORS_FILE), None)
        for node in launched.nodes:
            # `process_died` replaces respawn.py, which takes 9 MB for a node. If this process is
            # killed, the kernel interrupts the node
            node.launch_prefix = 'setpriv --pdeathsig INT'
            node.env_args = [*node.env_args, (_LOG_FORMAT[0], os.environ.get(*_LOG_FORMAT)),
                             *([(lifecycle.SUPERVISED, '1')] if node.respawn else [])]
        roslib.set_interactive(True)        # roslaunch leaves the signals to this node
        self._monitor = pmon.ProcessMonitor(robot.name)
        self._monitor.add_process_listener(self)
        self._monitor.start()
        try:
            launch.ROSLaunchRunner(
                rlutil.get_or_generate_uuid(None, False), launched, pmon=self._monitor,
                sigint_timeout=_SIGINT_TIMEOUT_S).launch()
        except Exception:
            self.wait()
            raise
        self._monitor.registrations_complete()

    def process_died(self, name: str, exit_code: Optional[int]) -> None:
        """Have roslaunch start a node again by the rules of respawn.py.

        roslaunch calls it again and again until the node is started.
        """
        process = self._monitor.get_process(name)
        since_s = process.time_of_death - self._died_s.get(name, 0.0)
        if process.package == 'img_recog' and since_s:
            self._died_s[name] = process.time_of_death
            process.respawn &= (exit_code or 0) < 0 or exit_code in _STARTED_AGAIN
            process.respawn_delay = 0.0 if since_s > _OFTEN_S else min(
                _MAX_DELAY_S, max(_FIRST_DELAY_S, 2 * process.respawn_delay))
            if exit_code == lifecycle.EXIT_REFUSED:
                self.interrupt()

    def has_just_ended(self) -> bool:
        """Return whether all nodes have ended since the last call."""
        had_ended, self.has_ended = self.has_ended, self._monitor.done
        return self.has_ended and not had_ended

    def interrupt(self) -> None:
        """Ask the nodes to end."""
        self._monitor.shutdown()

    def wait(self) -> None:
        """End the nodes; if `interrupt` has done so, wait for it."""
        self._monitor.shutdown()
        self._monitor.join()


def arguments(robot: RobotRow, values: Mapping[str, Any]) -> List[str]:
    """Return the arguments of robot.launch."""
    values = {'name': robot.name, **dataclasses.asdict(robot.nodes), **values}
    return ['{}:={}'.format(key, str(value).lower() if isinstance(value, bool) else value)
            for key, value in values.items() if key != 'urdf']      # in robot_description
