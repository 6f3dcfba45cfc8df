"""Find in the output of roslaunch which node has ended with an error, and why."""
import os
import re
import signal
from typing import NamedTuple, Optional

PARTS = {'master': 'the ROS master', 'gazebo': 'the simulator', 'usb_cam': 'the camera',
         'color_extract': 'the recognition',
         'turtlebot3_teleop_keyboard': 'the teleop', 'robot_state_publisher': 'the tf tree',
         'image_view': 'the window of the camera images',
         'image_view_blue': 'the window of the blue image',
         'image_view_red': 'the window of the red image', 'web': 'the page',
         'robots': 'the node that runs the robots', 'record': 'the recording'}

_COLOR = re.compile(r'\x1b\[[0-9;]*m')
_REQUIRED = re.compile(r'REQUIRED process \[(\S+?)(?:-\d+)?\] has died!')
_FINISHED = 'process has finished cleanly'
_DIED = re.compile(r'process has died \[pid \d+, exit code (-?\d+), cmd (.*)\]\.$')
_NODE = re.compile(r'^\[(\S+)-\d+\] ')
# of scripts/respawn.py
_GAVE_UP = re.compile(r'^\[respawn\] (\S+): ended(, and the demo with it| and is not started '
                      r'again): (.*)')
_NO_ERROR = ('it has finished', 'another node has taken its name')
_STARTED_AGAIN = re.compile(r'^\[respawn\] (\S+): (.*), started again')
_RESTARTING = re.compile(r'^\[(\S+)-\d+\] restarting process')
_NO_NODE = re.compile(r'ERROR: (cannot launch node of type \[\S+/(\S+)\]: .*)')
_LOGGED = re.compile(r'^\[rosout\]\[(?:CRITICAL|ERROR)\] \S+ \S+ (.*)')
_ON_SCREEN = re.compile(r'^\[(?:FATAL|ERROR)\] \[[^]]*\]: (.*)')
_EXCEPTION = re.compile(r'^[\w.]*(?:Error|Exception|Interrupt)\b.*')


class Death(NamedTuple):
    """The end of a node. required: whether roslaunch ends with it; is_over: whether the node is
    not started again.
    """

    node: str
    required: bool
    reason: str
    is_over: bool = True


class LaunchOutput:
    """Reads the output line by line and finds the nodes that have ended with an error.

    launching: whether roslaunch has started a process. exception: the last one that was printed
    and is not the reason of a node.
    """

    def __init__(self) -> None:
        self.launching = False
        self._required: Optional[str] = None
        self.exception = ''

    def read(self, line: str) -> Optional[Death]:
        """Return the Death that a line reports, or None."""
        line = plain(line)
        self.launching = self.launching or line.startswith('process[')
        if _EXCEPTION.match(line):
            self.exception = line
        respawn = self._read_respawn(line)
        if respawn:
            return respawn
        required = _REQUIRED.search(line)
        if required:
            self._required = required.group(1)
            return None
        missing = _NO_NODE.match(line)
        if missing:
            return Death(missing.group(2), False, missing.group(1))
        died = _DIED.search(line)
        node = _NODE.match(line)
        if died and (node or self._required):
            name = node.group(1) if node else self._required or ''
            return self._death(name, not node, int(died.group(1)), died.group(2))
        if self._required and line == _FINISHED:
            return self._death(self._required, True, 0, '')
        return None

    def _read_respawn(self, line: str) -> Optional[Death]:
        """Return the Death that a line of respawn.py, or of roslaunch's respawn, reports."""
        gave_up = _GAVE_UP.match(line)
        if gave_up:
            node, end, reason = gave_up.groups()
            is_required = end.startswith(',')
            if reason in _NO_ERROR and not is_required:
                return None
            if reason.startswith('exit code'):
                reason = self.exception or reason
            self.exception = ''
            return Death(node, is_required, reason)
        again = _STARTED_AGAIN.match(line)
        if again:
            self.exception = ''
            return Death(again.group(1), False, again.group(2), False)
        restarting = _RESTARTING.match(line)
        if restarting:
            return Death(restarting.group(1), False, 'its process died', False)
        return None

    def _death(self, node: str, required: bool, code: int, command: str) -> Death:
        log = re.search(r'__log:=(\S+)', command)
        reason = described(code)
        if code >= 0:       # else its own messages are not the reason
            reason = (last_error(log.group(1)) if log else '') or self.exception or reason
        self._required, self.exception = None, ''
        return Death(node, required, reason)


def plain(line: str) -> str:
    """Return a line without colors and without the space at its end."""
    return _COLOR.sub('', line).rstrip()


def last_error(path: str) -> str:
    """Return the last message at ERROR or above in the log file of a node, or ''."""
    if not os.path.isfile(path):
        return ''
    with open(path, errors='replace') as file:
        found = [_LOGGED.match(line) or _ON_SCREEN.match(line) for line in file]
    return next((match.group(1) for match in reversed(found) if match), '')


def described(code: int) -> str:
    """Return how a process has ended; code: its exit code, or the negative number of a signal."""
    if code < 0:
        names = {signum.value: signum.name for signum in signal.Signals}
        return 'killed by {}'.format(names.get(-code, 'signal {}'.format(-code)))
    return 'exit code {}'.format(code)


def describe(death: Death) -> str:
    """Return one line about which part is missing, and why."""
    return '{} ({}) has ended: {}'.format(
        PARTS.get(death.node.rpartition('/')[2], 'a node'), death.node, death.reason.rstrip('.'))
