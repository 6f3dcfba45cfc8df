"""Single nodes with a master of their own, for programs that treat them badly."""
import os
import tempfile
import uuid
from typing import Dict, List, Optional

from img_recog_testing.processes import Process, Ros
from img_recog_testing.reliability import usage, wire
from img_recog_testing.waiting import DEADLINE_S, wait_for

ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), *3 * ['..']))
_URDF = os.path.join(ROOT, 'urdf', 'turtlebot3_burger.urdf')


class Nodes:
    """A master on a free port, and nodes that are started on it; use it in a with statement."""

    def __init__(self) -> None:
        self._folder = tempfile.TemporaryDirectory(prefix='img_recog_nodes_')
        self.folder = self._folder.name
        self.temporary = os.path.join(self.folder, 'tmp')
        os.mkdir(self.temporary)
        self.marker = 'IMG_RECOG_UNDER_TEST=' + uuid.uuid4().hex
        self._ros = ros = Ros(_Folder(self.folder))     # keeps the port
        self.env = dict(ros.env, TMPDIR=self.temporary)
        self.env.update([self.marker.split('=')])
        self.master, self._port = self.env['ROS_MASTER_URI'], ros.port
        self._processes: List[Process] = []
        # not marked: it is not under test
        self._core = Process(['rosmaster', '--core', '-p', ros.port], ros.env)

    def __enter__(self) -> 'Nodes':
        wait_for(lambda: wire.answers(self.master), lambda: 'the master\n' + self._core.output)
        return self

    def __exit__(self, *_) -> None:
        usage.end_all(self.marker)
        for process in self._processes + [self._core]:
            process.close()
        self._folder.cleanup()

    def start(self, script: str, *arguments: str, env: Optional[Dict[str, str]] = None,
              **popen) -> Process:
        """Start a script of this package; a simulator gets the robot's description."""
        if script == 'pybullet_sim.py':
            with open(_URDF) as file:
                wire.call(self.master, 'setParam', '/robot_description', file.read())
        return self.start_command([_script(script), *arguments], env, **popen)

    def start_command(self, command: List[str], env: Optional[Dict[str, str]] = None,
                      **popen) -> Process:
        """Start any command."""
        process = Process(command, dict(self.env, **(env or {})), **popen)
        self._processes.append(process)
        return process

    def forget(self, process: Process) -> None:
        """Drop a process that has ended, and its output."""
        self._processes.remove(process)

    def set_parameter(self, name: str, value) -> None:
        wire.call(self.master, 'setParam', name, value)

    def wait_for_node(self, node: str) -> str:
        """Wait until a node has registered and answers; return its address."""
        def address():
            try:
                uri = wire.node_uri(self.master, node)
                wire.call(uri, 'getPid')
                return uri
            except wire.ERRORS:
                return None
        return wait_for(address, lambda: 'node {}\n{}'.format(node, self.output()[-3000:]))

    def subscribe(self, node: str, topic: str, data_class: type) -> wire.Subscription:
        """Subscribe to a topic once the node publishes it."""
        def subscription():
            try:
                return wire.Subscription(self.master, node, topic, data_class, DEADLINE_S)
            except wire.ERRORS:
                return None
        return wait_for(subscription, lambda: '{} of {}\n{}'.format(
            topic, node, self.output()[-3000:]))

    def pid(self, process: Process) -> int:
        self.check_alive(process)
        return process.pid

    def check_alive(self, process: Process) -> None:
        """Raise AssertionError if a process has ended."""
        code = process._popen.poll()
        assert code is None, 'it has ended with code {}:\n{}'.format(code, process.output[-3000:])

    def output(self) -> str:
        """Return what the nodes have printed, one after the other."""
        return ''.join(process.output for process in self._processes)


def _script(name: str) -> str:
    """Return the path of a script, with the interpreter of the build."""
    for folder in os.environ.get('CMAKE_PREFIX_PATH', '').split(os.pathsep):
        path = os.path.join(folder, 'lib', 'img_recog', name)
        if os.path.exists(path):
            return path
    raise FileNotFoundError('{} is not built; use ./run test'.format(name))


class _Folder(str):
    """The part of pathlib.Path that Ros needs."""

    def __truediv__(self, name: str) -> str:
        return os.path.join(self, name)
