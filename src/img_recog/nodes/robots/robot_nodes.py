"""Runs the nodes of a robot."""
import dataclasses
import os
import signal
import subprocess
import time
from typing import Any, List, Mapping, Optional

from img_recog.nodes.robots.robot_list import RobotRow
from img_recog.processes import process_tree

LONG_LIFE_S = 10.0         # of a roslaunch that is started again if it ends
_LOG_FORMAT = '[${severity}] [${time}] ${node}: ${message}'     # the node names the robot
_EXIT_TIMEOUT_S = 12.0      # roslaunch waits up to 15 s for the node that runs this


class RobotNodes:
    """A roslaunch of robot.launch. To be used in the main thread: it ends with that thread.

    robot: whose nodes they are.
    """

    def __init__(self, robot: RobotRow, arguments: Mapping[str, Any]):
        """Start the nodes of a robot; arguments: of robot.launch that are not in `robot`."""
        self.robot, self._command = robot, command(robot, arguments)
        self._process: Optional[subprocess.Popen] = None
        self._start()

    def _start(self) -> None:
        self._started_s = time.monotonic()
        # its own group: a Ctrl-C ends it by way of `stop`
        self._process = subprocess.Popen(
            self._command, env={'ROSCONSOLE_FORMAT': _LOG_FORMAT, **os.environ},
            stdin=subprocess.DEVNULL, start_new_session=True)

    @property
    def has_ended(self) -> bool:
        """Whether the nodes have ended and are not started again."""
        return self._process is None

    def check(self) -> Optional[str]:
        """Start the nodes again if they have ended; return a line if they were, else None.

        If roslaunch was killed, its nodes go on: the new ones take their names.
        """
        if self._process is None or self._process.poll() is None:
            return None
        code, self._process = self._process.returncode, None
        if code >= 0 and time.monotonic() - self._started_s < LONG_LIFE_S:
            return 'its nodes have ended with exit code {}, and are not started again'.format(code)
        self._start()
        return 'its nodes have ended with exit code {}, and are started again'.format(code)

    def interrupt(self) -> None:
        """Ask the nodes to end."""
        if self._process is not None and self._process.poll() is None:
            self._process.send_signal(signal.SIGINT)

    def wait(self) -> None:
        """Wait until the nodes have ended, after `interrupt`."""
        if self._process is not None:
            process_tree.wait_or_kill(self._process, _EXIT_TIMEOUT_S)
            self._process = None


def command(robot: RobotRow, arguments: Mapping[str, Any]) -> List[str]:
    """Return the command that runs the nodes of a robot."""
    values = {'name': robot.name, **dataclasses.asdict(robot.nodes), **arguments}
    del values['urdf']      # it is in the parameter robot_description
    # if this process is killed, roslaunch is interrupted and ends the nodes
    return ['setpriv', '--pdeathsig', 'INT', 'roslaunch', '--no-summary', '--disable-title',
            '--skip-log-check', 'img_recog', 'robot.launch',
            *('{}:={}'.format(key, str(value).lower() if isinstance(value, bool) else value)
              for key, value in values.items())]
