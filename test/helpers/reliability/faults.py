"""Faults of a running demo: what they do, and how their details are drawn at random."""
import contextlib
import os
import random
import signal
import subprocess
import sys
import time
from typing import Any, Callable, Dict, Iterator, NamedTuple, Tuple

from img_recog.ros.transport.switch import is_plain
from img_recog_helpers import process_table, wire
from img_recog_helpers.reliability import chain
from img_recog_helpers.reliability.demo import NODES, Demo
from img_recog_helpers.waiting import DEADLINE_S, wait_for

_BUSY = 'while True: pass'
_LONG_LIFE_S = 5.0         # scripts/respawn.py has 4 s
# what can be subscribed to at each node; the image is the largest
_TOPICS = {'usb_cam': chain.CAMERA, 'color_extract': chain.COMMAND, 'gazebo': chain.ODOMETRY,
           'turtlebot3_teleop_keyboard': chain.TELEOP, 'robot_state_publisher': chain.JOINTS}
# roscpp is not ours: a reader that stalls is its own matter
OURS = tuple(name for name in NODES if name != 'robot_state_publisher')


class Fault(NamedTuple):
    """What happens to which node; `details` are the arguments of its kind."""

    kind: str
    node: str
    details: Tuple[Any, ...] = ()

    def __str__(self) -> str:
        return ' '.join([self.kind, self.node, *map(str, self.details)])


# a context, whose value is when the chain began to be able to recover
Undo = Iterator[float]


@contextlib.contextmanager
def kill(demo: Demo, fault: Fault) -> Undo:
    """End a node by a signal, or as `rosnode kill` does.

    A node that dies again soon is started again later and later: so it lives for a while first.
    """
    pid, (how,) = demo.pid(fault.node), fault.details
    if fault.node in demo.killed:
        wait_for(lambda: process_table.age_s(pid) > _LONG_LIFE_S, 'the age of ' + fault.node)
    demo.killed.add(fault.node)
    begin = time.monotonic()
    if how == 'rosnode':
        uri = wire.node_uri(demo.master_uri, '/' + fault.node)
        with contextlib.suppress(*wire.ERRORS):         # it may end before it answers
            wire.call(uri, 'shutdown', 'by chaos')
    else:
        os.kill(pid, getattr(signal, how))
    wait_for(lambda: not process_table.is_alive(pid), 'the end of ' + fault.node)
    yield begin


@contextlib.contextmanager
def pause(demo: Demo, fault: Fault) -> Undo:
    """Stop a node for some seconds, then let it run on."""
    pid, (duration_s,) = demo.pid(fault.node), fault.details
    os.kill(pid, signal.SIGSTOP)
    try:
        time.sleep(duration_s)
    finally:
        os.kill(pid, signal.SIGCONT)
    yield time.monotonic()


@contextlib.contextmanager
def starve(demo: Demo, fault: Fault) -> Undo:
    """Let a node share one core with busy loops, with a higher priority if that is allowed."""
    pid, (duration_s, loops) = demo.pid(fault.node), fault.details
    cores = os.sched_getaffinity(pid)
    core = {min(cores)}
    _pin(pid, core)
    busy = [subprocess.Popen([sys.executable, '-c', _BUSY], env=demo.env) for _ in range(loops)]
    try:
        for each in busy:
            os.sched_setaffinity(each.pid, core)
            with contextlib.suppress(PermissionError):
                os.setpriority(os.PRIO_PROCESS, each.pid, -10)
        time.sleep(duration_s)
    finally:
        for each in busy:
            each.kill()
            each.wait()
        _pin(pid, cores)
    yield time.monotonic()


def _pin(pid: int, cores) -> None:
    for thread in os.listdir('/proc/{}/task'.format(pid)):
        with contextlib.suppress(ProcessLookupError):
            os.sched_setaffinity(int(thread), cores)


@contextlib.contextmanager
def master(demo: Demo, fault: Fault) -> Undo:
    """End the master, and start another one that knows nothing.

    roscpp never registers again, so robot_state_publisher has to be started again.
    """
    how, down_s = fault.details
    demo.kill_master(getattr(signal, how))
    time.sleep(down_s)
    demo.start_master()
    os.kill(demo.pid('robot_state_publisher'), signal.SIGTERM)
    yield time.monotonic()


@contextlib.contextmanager
def readers(demo: Demo, fault: Fault) -> Undo:
    """Subscribe many times and never read; the chain has to work while they are there."""
    stream, (count,) = _TOPICS[fault.node], fault.details
    with contextlib.ExitStack() as stack:
        for number in range(count):
            stack.callback(wire.Subscription(
                demo.master_uri, stream.node, stream.topic, stream.data_class, DEADLINE_S,
                buffer_bytes=4096, caller='/reader_{}'.format(number)).close)
        yield time.monotonic()


APPLY: Dict[str, Callable] = {each.__name__: each for each in (
    kill, pause, starve, master, readers)}
KINDS = tuple(APPLY)


def possible() -> Tuple[str, ...]:
    """Return the kinds of faults that the transport in use survives."""
    left_out = 'master' if is_plain('registration') else None
    return tuple(kind for kind in KINDS if kind != left_out)


_DETAILS: Dict[str, Callable[[random.Random], Tuple]] = {
    'kill': lambda rng: (rng.choice(('SIGKILL', 'SIGTERM', 'rosnode')),),
    'pause': lambda rng: (round(rng.uniform(1.0, 10.0), 1),),
    'starve': lambda rng: (round(rng.uniform(2.0, 6.0), 1), rng.randint(1, 4)),
    'master': lambda rng: (rng.choice(('SIGKILL', 'SIGINT')), round(rng.uniform(0.0, 4.0), 1)),
    'readers': lambda rng: (rng.randint(10, 100),)}


def draw(rng: random.Random, kinds: Tuple[str, ...] = KINDS) -> Fault:
    """Return a fault with everything about it drawn at random."""
    kind = rng.choice(kinds)
    node = rng.choice(OURS if kind == 'readers' else NODES)
    return Fault(kind, 'master' if kind == 'master' else node, _DETAILS[kind](rng))
