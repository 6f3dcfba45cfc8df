"""A running demo of its own, with everything that it leaves behind."""
import contextlib
import os
import re
import signal
import time
from typing import Dict, Iterator, List, Optional, Set

import psutil

from img_recog_helpers import process_table
from img_recog_helpers.process_table import Usage
from img_recog_helpers.processes import Process
from img_recog_helpers.reliability import chain
from img_recog_helpers.reliability.nodes import Contained
from img_recog_helpers.waiting import wait_for

NODES = ('usb_cam', 'color_extract', 'gazebo', 'turtlebot3_teleop_keyboard',
         'robot_state_publisher')
LIMIT_S = 5.0               # until the chain works again after any fault
START_LIMIT_S, STOP_LIMIT_S = 60.0, 15.0
_NAME = re.compile(r'__name:=([\w/]+)')


class Demo(Contained):
    """Demo and master, with a film as camera, an empty world and no window."""

    def __init__(self) -> None:
        super().__init__()
        self.launch: Optional[Process] = None
        self.chain = chain.Chain(self.master_uri)
        self.killed: Set[str] = set()       # nodes that were killed before

    def start_all(self, *arguments: str) -> None:
        """Start master and demo."""
        film, colors = (os.path.join(self.folder, name) for name in ('film.avi', 'colors.yaml'))
        chain.write_film(film)
        with open(colors, 'w') as file:
            file.write(chain.COLORS)
        self.start_master()
        self.launch = self.demo('camera:=' + film, 'colors:=' + colors, 'world:=empty',
                                'gui:=false', 'image_view:=false', *arguments)

    def pids(self) -> Dict[str, List[int]]:
        """Return the process ids of each node, by its name."""
        found: Dict[str, List[int]] = {}
        for pid, line in process_table.marked(self.marker).items():
            name = node_name(line)
            if name is not None:
                found.setdefault(name, []).append(pid)
        return found

    def pid(self, node: str) -> int:
        """Return the process id of a node; raises LookupError unless it runs exactly once."""
        pids = self.pids().get(node, [])
        if len(pids) != 1:
            raise LookupError('{} runs {} times'.format(node, len(pids)))
        return pids[0]

    def usage(self) -> Dict[str, Usage]:
        """Return what each running node uses."""
        found = {}
        for name, pids in self.pids().items():
            if name in NODES and len(pids) == 1:
                with contextlib.suppress(psutil.NoSuchProcess):
                    found[name] = process_table.usage(pids[0])
        return found

    def stop(self, limit_s: float) -> float:
        """Interrupt demo and master; return the seconds until no process is left.

        Raises AssertionError if a process is left after the limit, or a temporary file.
        """
        start = time.monotonic()
        self.launch.send_signal(signal.SIGINT)
        wait_for(lambda: set(self.pids()) <= {'rosout'},
                 lambda: process_table.marked(self.marker), limit_s)
        took_s = time.monotonic() - start
        self.kill_master(signal.SIGINT)
        wait_for(lambda: not process_table.marked(self.marker),
                 lambda: 'the end of {}'.format(process_table.marked(self.marker)), limit_s)
        assert self.temporary_files() == [], self.temporary_files()
        return took_s

    def close(self) -> None:
        self.chain.close()
        super().close()


@contextlib.contextmanager
def running(factor: float, **env: str) -> Iterator[Demo]:
    """Start a demo; after the block, stop it, and check that it leaves nothing.

    factor: of the time limits. env: additions to its environment.
    """
    with Demo() as demo:
        demo.env.update(env)
        demo.start_all()
        demo.chain.wait(START_LIMIT_S * factor)
        yield demo
        demo.stop(STOP_LIMIT_S * factor)


def problems(before: Dict[str, Usage], after: Dict[str, Usage],
             extra: Dict[str, float]) -> List[str]:
    """Return a line for each node that has ended, or uses more than before.

    extra: how much more a node may use of each value of Usage.
    """
    return [name + ' does not run' for name in before if name not in after] + [
        '{} has {:.0f} {}, {:.0f} before'.format(name, getattr(used, what), what,
                                                 getattr(before[name], what))
        for name, used in after.items() for what, limit in extra.items()
        if getattr(used, what) > getattr(before[name], what) + limit]


def node_name(line: str) -> Optional[str]:
    """Return the name that roslaunch gave to a node, from its command line.

    None for another process, also for the one that starts the node again (scripts/respawn.py).
    """
    match = None if 'respawn.py' in line else _NAME.search(line)
    return match.group(1) if match else None
