"""A running demo of its own, with everything that it leaves behind."""
import os
import re
import signal
import time
import uuid
from typing import Dict, List, Optional, Set

from img_recog_testing.processes import Process, Ros
from img_recog_testing.reliability import chain, usage, wire
from img_recog_testing.waiting import wait_for

NODES = ('usb_cam', 'color_extract', 'gazebo', 'turtlebot3_teleop_keyboard',
         'robot_state_publisher')


class Demo:
    """Demo and master on a free port, with a film as camera, an empty world and no window."""

    def __init__(self, folder: str):
        """folder: an empty folder for logs, temporary files and the film."""
        self.folder, self.temporary = folder, os.path.join(folder, 'tmp')
        os.mkdir(self.temporary)
        self.marker = 'IMG_RECOG_UNDER_TEST=' + uuid.uuid4().hex
        self._ros = Ros(_Path(folder))
        self._ros.env.update([self.marker.split('=')], TMPDIR=self.temporary)
        self.master = self._ros.env['ROS_MASTER_URI']
        self.env = self._ros.env
        self._core: Optional[Process] = None
        self.launch: Optional[Process] = None
        self.chain = chain.Chain(self.master)
        self.killed: Set[str] = set()       # nodes that were killed before

    def start(self, *arguments: str) -> None:
        """Start master and demo."""
        film, colors = (os.path.join(self.folder, name) for name in ('film.avi', 'colors.yaml'))
        chain.write_film(film)
        with open(colors, 'w') as file:
            file.write(chain.COLORS)
        self.start_master()
        self.launch = Process(
            ['roslaunch', 'img_recog', 'demo.launch', 'camera:=' + film, 'colors:=' + colors,
             'world:=empty', 'gui:=false', 'image_view:=false', 'web:=false', *arguments],
            self.env)

    def start_master(self) -> None:
        """Start the master; return when it answers."""
        self._core = Process(['roscore', '-p', self._ros.port], self.env)
        wait_for(lambda: wire.answers(self.master), lambda: 'the master:\n' + self._core.output)

    def stop_master(self, signum: int) -> None:
        """End the master by a signal to its processes; return when none of them runs."""
        for pid, line in usage.marked(self.marker).items():
            if re.search(r'\broscore\b|\brosmaster\b|__name:=rosout\b', line):
                _signal(pid, signum)
        wait_for(lambda: not any(re.search(r'\broscore\b|\brosmaster\b|__name:=rosout\b', line)
                                 for line in usage.marked(self.marker).values()), 'its end')

    def pid(self, node: str) -> int:
        """Return the process id of a node; raises LookupError unless it runs exactly once."""
        pids = usage.nodes(self.marker).get(node, [])
        if len(pids) != 1:
            raise LookupError('{} runs {} times'.format(node, len(pids)))
        return pids[0]

    def usage(self) -> Dict[str, usage.Usage]:
        """Return what each running node uses."""
        found = {}
        for name, pids in usage.nodes(self.marker).items():
            if name in NODES and len(pids) == 1:
                try:
                    found[name] = usage.of(pids[0])
                except OSError:
                    continue
        return found

    def temporary_files(self) -> List[str]:
        return sorted(os.listdir(self.temporary))

    def stop(self, limit_s: float) -> float:
        """Interrupt demo and master; return the seconds until no process is left.

        Raises AssertionError if a process is left after the limit, or a temporary file.
        """
        start = time.monotonic()
        if self.launch is not None:
            _signal(self.launch.pid, signal.SIGINT)
        try:
            wait_for(lambda: set(usage.nodes(self.marker)) <= {'rosout'},
                     lambda: usage.marked(self.marker), limit_s)
            took_s = time.monotonic() - start
            self.stop_master(signal.SIGINT)
            wait_for(lambda: not usage.marked(self.marker),
                     lambda: 'the end of {}'.format(usage.marked(self.marker)), limit_s)
            assert self.temporary_files() == [], self.temporary_files()
            return took_s
        finally:
            self.close()

    def close(self) -> None:
        """Kill what is left."""
        self.chain.close()
        usage.end_all(self.marker)
        for process in (self.launch, self._core):
            if process is not None:
                process.close()


class _Path(str):
    """The part of pathlib.Path that Ros needs."""

    def __truediv__(self, name: str) -> str:
        return os.path.join(self, name)


def _signal(pid: int, signum: int) -> None:
    try:
        os.kill(pid, signum)
    except ProcessLookupError:
        pass
