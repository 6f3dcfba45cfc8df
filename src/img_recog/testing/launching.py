"""Launch files that run as a child process, and what their nodes print."""
import collections
import operator
import os
import re
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as ElementTree
from typing import (Any, Callable, Deque, Dict, List, Mapping, NamedTuple, Optional, Sequence, Set,
                    Tuple, Union)
from xml.sax.saxutils import quoteattr

import roslaunch
import roslaunch.config
import roslaunch.rlutil
import roslaunch.xmlloader
import rospkg
from roslaunch.substitution_args import SubstitutionException, resolve_args

from img_recog.errors import UserError, one_line
from img_recog.processes import process_tree
from img_recog.processes.launch_output import Death, LaunchOutput, plain

# what a failed test does not show: lines of this package between the test and the reason. pytest
# calls it with what was raised
of_reasons = operator.methodcaller('errisinstance', (AssertionError, UserError))
__tracebackhide__, __unittest = of_reasons, True
Given = Union[None, str, Tuple, List]

_SUPERVISOR = os.path.join(os.path.dirname(os.path.abspath(__file__)), 'supervisor.py')
# roslaunch needs distutils: that of setuptools takes 0.2 s more
_FASTER = {'SETUPTOOLS_USE_DISTUTILS': 'stdlib'} if os.path.exists(
    os.path.join(os.path.dirname(os.__file__), 'distutils', 'spawn.py')) else {}
_LOG_FORMAT = '[${severity}] [${time}] ${node}: ${message}'
_STARTED = re.compile(r'^process\[(\S+)-\d+\]: started')
_CORE = '/rosout'
_KEPT_LINES, _SHOWN_LINES = 400, 15
_END_TIMEOUT_S = 20.0       # longer than supervisor.py takes


class LaunchFile(NamedTuple):
    """A launch file. path: absolute; arguments: by their names."""

    path: str
    arguments: Mapping[str, Any]


def launch_files(given: Given) -> List[LaunchFile]:
    """Return the launch files that a user gave.

    A path, or ('package', 'file.launch'), either with a dict of its arguments at the end, or a
    list of these. Raises UserError.
    """
    if given is None:
        return []
    each = given if isinstance(given, list) else [given]
    return [_launch_file(one) for one in each]


def _launch_file(given: Any) -> LaunchFile:
    words = given if isinstance(given, tuple) else (given,)
    arguments: Mapping[str, Any] = {}
    if len(words) > 1 and isinstance(words[-1], Mapping):
        words, arguments = words[:-1], words[-1]
    if not 1 <= len(words) <= 2 or not all(
            isinstance(word, (str, os.PathLike)) for word in words):
        raise UserError('launch: got {!r}'.format(given), 'give a path, or (\'package\', '
                        '\'file.launch\'), either with a dict of its arguments at the end')
    if len(words) == 1:
        path = os.path.abspath(os.path.expanduser(words[0]))
        if not os.path.isfile(path):
            raise UserError('launch: there is no file {}'.format(path), 'give its path, or '
                            '(\'package\', \'file.launch\')')
        return LaunchFile(path, arguments)
    try:
        return LaunchFile(roslaunch.rlutil.resolve_launch_arguments(list(words))[0], arguments)
    except roslaunch.RLException as error:
        raise UserError('launch: {}'.format(one_line(error)), 'is the package built, and its '
                        'setup.bash sourced?') from None


def _text(value: Any) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)


def _together(files: Sequence[LaunchFile]) -> str:
    """Return a launch file that includes all; UserError if one does not take its arguments."""
    lines = []
    for file in files:
        unused = sorted(file.arguments.keys() - _taken(file.path))
        if unused:
            raise UserError('the launch files cannot be used: unused args [{}] for include of [{}]'
                            .format(', '.join(unused), file.path), 'try them with roslaunch')
        # roslaunch would refuse what a file only hands on to those that it includes
        lines += ['<include ns="/" pass_all_args="true" file={}>'.format(quoteattr(file.path)),
                  *('<arg name={} value={}/>'.format(quoteattr(name), quoteattr(_text(value)))
                    for name, value in file.arguments.items()), '</include>']
    return '<launch>{}</launch>\n'.format('\n'.join(lines))


def _taken(path: str) -> Set[str]:
    """Return the names of a launch file's arguments, and of those that it hands on.

    Raises UserError if it cannot be read.
    """
    try:
        root = ElementTree.parse(path).getroot()
        names = {arg.get('name', '') for arg in root.iter('arg') if arg.get('value') is None}
        for part in root.iter('include'):
            if part.get('pass_all_args', '').lower() in ('true', '1'):
                names |= _taken(resolve_args(part.get('file', '')))
        return names
    except (OSError, ElementTree.ParseError, SubstitutionException,
            rospkg.ResourceNotFound) as error:
        raise UserError('the launch files cannot be used: {}: {}'.format(path, one_line(error)),
                        'try them with roslaunch') from None


class Launch:
    """A roslaunch of some launch files; all that it starts ends with this process.

    log: the last lines of all nodes.
    """

    def __init__(self, files: Sequence[LaunchFile], path: str):
        """Start it. path: where to write a launch file that includes all.

        Raises UserError if roslaunch would refuse one.
        """
        with open(path, 'w') as file:
            file.write(_together(files))
        # what roslaunch adds, of roscore, starts two programs
        config = roslaunch.config.ROSLaunchConfig()
        try:
            roslaunch.xmlloader.XmlLoader().load(path, config, verbose=False)
        except roslaunch.RLException as error:
            raise UserError('the launch files cannot be used: {}'.format(one_line(error)),
                            'try them with roslaunch') from None
        errors = ', '.join(map(str, config.config_errors))
        if errors:
            raise UserError('the launch files cannot be used: {}'.format(one_line(errors)))
        self._respawned = {_name(node) for node in config.nodes if node.respawn}
        self._count = len(config.nodes)
        self.log: Deque[str] = collections.deque(maxlen=_KEPT_LINES)
        self._started: Dict[str, None] = {}
        self._finished: List[str] = []
        self._deaths: List[Death] = []
        self._process = subprocess.Popen(
            [sys.executable, _SUPERVISOR, 'roslaunch', '--screen', '--no-summary',
             '--disable-title', '--skip-log-check', path],
            # OpenCV's own threads wait in a busy loop, on a core that draws the next image
            env={'ROSCONSOLE_FORMAT': _LOG_FORMAT, 'PYTHONUNBUFFERED': '1',
                 'OPENCV_FOR_THREADS_NUM': '1', **_FASTER, **os.environ, 'PWD': os.getcwd()},
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            start_new_session=True)         # Ctrl-C is for the test, which ends this then
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        output = LaunchOutput()
        assert self._process.stdout is not None
        for data in self._process.stdout:
            line = plain(data.decode(errors='replace'))
            self.log.append(line)
            started = _STARTED.match(line)
            if started:
                self._started['/' + started.group(1)] = None
            if line.endswith('process has finished cleanly'):
                self._finished.append('/' + line[1:].rpartition('-')[0])
            death = output.read(line)
            if death is not None and death.is_over and '/' + death.node not in self._respawned:
                self._deaths.append(death)

    @property
    def nodes(self) -> List[str]:
        """The names of the nodes that were started and have not finished."""
        return [name for name in self._started if name != _CORE and name not in self._finished]

    @property
    def is_complete(self) -> bool:
        """Whether all nodes were started."""
        return len(set(self._started) - {_CORE}) >= self._count

    def check(self, is_end_near: bool = False) -> None:
        """Raise AssertionError if a node has died that is not started again, or roslaunch.

        is_end_near: whether one seems to be dying; then wait for that.
        """
        if is_end_near:
            self._wait(lambda: bool(self._deaths))
        if self._process.poll() is not None:
            self._reader.join(_END_TIMEOUT_S)
        if self._deaths:
            death = self._deaths[0]
            raise AssertionError('the node {} has ended: {}\n{}'.format(
                death.node, death.reason, self.tail()))
        if self._process.poll() is not None:
            raise AssertionError('roslaunch has ended\n{}'.format(self.tail()))

    def _wait(self, is_reached: Callable[[], bool]) -> None:
        """Wait until something is reached, or roslaunch has ended, or for _END_TIMEOUT_S."""
        end_s = time.monotonic() + _END_TIMEOUT_S
        while not is_reached() and self._reader.is_alive() and time.monotonic() < end_s:
            self._reader.join(0.05)

    def tail(self) -> str:
        """Return the last lines of all nodes as a text."""
        lines = list(self.log)[-_SHOWN_LINES:]
        return '\n'.join(['the last lines of the nodes:', *('    ' + line for line in lines)])

    def find(self, text: str) -> Optional[str]:
        """Return the newest line with a text in it, None if there is none."""
        return next((line for line in reversed(self.log) if text in line), None)

    def end(self) -> None:
        """End all nodes, and wait for that."""
        assert self._process.stdin is not None
        self._process.stdin.close()
        process_tree.wait_or_kill(self._process, _END_TIMEOUT_S)
        self._reader.join(_END_TIMEOUT_S)
        assert self._process.stdout is not None
        self._process.stdout.close()


def _name(node: Any) -> str:
    return node.namespace.rstrip('/') + '/' + node.name
