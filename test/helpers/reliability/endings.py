"""Stops and kills of each program at random moments of its start and run."""
import contextlib
import os
import random
import signal
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from typing import Callable, Dict, Iterator, List, NamedTuple, Optional, Tuple

from sensor_msgs.msg import Image

from img_recog.ros import lifecycle
from img_recog_helpers import process_table
from img_recog_helpers.pages import ROOT
from img_recog_helpers.processes import Process
from img_recog_helpers import wire
from img_recog_helpers.reliability import chain
from img_recog_helpers.reliability.nodes import Nodes
from img_recog_helpers.waiting import wait_for

NODE_LIMIT_S, DEMO_LIMIT_S = 5.0, 12.0      # from the signal until nothing is left
_MAX_DELAY_S, _MAX_DEMO_DELAY_S = 3.0, 8.0
_DEMO_SHARE = 25                            # one of so many stops is one of the whole demo
_REPLAY_SHARE = 20                          # one of so many kills is one of replay.py
_SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
_VIEW = '/gazebo/view/image_raw'
# scripts, their nodes, what these print when they have started, and their arguments
_NODES: Dict[str, Tuple[str, ...]] = {
    'usb_cam_node.py': ('/usb_cam', 'camera: ', '_video_device:=synthetic'),
    'color_img_recog.py': ('/color_extract', 'blue='),
    'pybullet_sim.py': ('/gazebo', 'simulating'),
    'teleop_key.py': ('/turtlebot3_teleop_keyboard', 'no terminal')}


class Ending(NamedTuple):
    """What is ended, how, and how long after its start."""

    program: str
    signum: int
    delay_s: float
    viewed: bool = False        # the view of the simulator is drawn, by another process


class Endings(NamedTuple):
    """Seconds by program, and a line for each failure."""

    times_s: Dict[str, List[float]]
    failures: List[str]


def draw_stop(rng: random.Random) -> Ending:
    """Return a stop with everything drawn at random."""
    if rng.randrange(_DEMO_SHARE) == 0:
        return Ending('demo', rng.choice(_SIGNALS), rng.uniform(0.0, _MAX_DEMO_DELAY_S))
    return Ending(rng.choice(sorted(_NODES)), rng.choice(_SIGNALS),
                  rng.uniform(0.0, _MAX_DELAY_S), rng.random() < 0.3)


def draw_kill(rng: random.Random) -> Ending:
    """Return a kill with everything drawn at random."""
    if rng.randrange(_REPLAY_SHARE) == 0:
        return Ending('replay.py', signal.SIGKILL, rng.uniform(0.0, _MAX_DELAY_S))
    return Ending(rng.choice(sorted(_NODES)), signal.SIGKILL, rng.uniform(0.0, _MAX_DELAY_S),
                  rng.random() < 0.3)


def run(draw: Callable[[random.Random], Ending], count: int, seed: int, factor: float = 1.0,
        lanes: int = 2) -> Endings:
    """End `count` programs, in lanes at the same time, each of which has a master."""
    rng, endings = random.Random(seed), Endings({}, [])
    drawn = [draw(rng) for _ in range(count)]

    def work(lane):
        with Nodes() as nodes, _images(nodes):
            for ending in drawn[lane::lanes]:
                try:
                    took_s = _end(nodes, ending, factor)
                    endings.times_s.setdefault(ending.program, []).append(took_s)
                except (AssertionError, OSError) as error:
                    endings.failures.append('{}: {}'.format(ending, error))
                    process_table.end_all(nodes.marker)
    with ThreadPoolExecutor(lanes) as pool:
        list(pool.map(work, range(min(lanes, count))))
    return endings


@contextlib.contextmanager
def _images(nodes: Nodes) -> Iterator[None]:
    """Publish images that stop and go on: a node may be stopped just after the last one."""
    image = chain.message('blue')
    publisher = wire.RawPublisher(nodes.master_uri, '/usb_cam/image_raw', Image, '/images')
    ended = threading.Event()

    def publish():
        rng = random.Random(1)
        while not ended.wait(rng.choice((0.03,) * 30 + (0.3, 1.0))):
            publisher.publish(image)
    thread = threading.Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        publisher.close()


def _end(nodes: Nodes, ending: Ending, factor: float) -> float:
    """Start a program, end it, and return the seconds until nothing of it was left."""
    process = _start(nodes, ending)
    view = _wait(nodes, ending)
    # before, Python itself handles signals
    is_up = ending.program in _NODES and _NODES[ending.program][1] in process.output
    begin = time.monotonic()
    if process.is_running():
        send = os.killpg if ending.program == 'demo' and ending.signum == signal.SIGINT \
            else os.kill                    # a terminal sends Ctrl-C to all
        send(process.pid, ending.signum)
    limit_s = (DEMO_LIMIT_S if ending.program == 'demo' else NODE_LIMIT_S) * factor
    try:
        wait_for(lambda: not process_table.marked(nodes.marker),
                 lambda: 'the end of {}\n{}'.format(process_table.marked(nodes.marker),
                                                    process.output[-2000:]), limit_s)
        took_s = time.monotonic() - begin
        code = process.wait()
    finally:
        if view is not None:
            view.close()
        nodes.forget(process)
    if ending.signum != signal.SIGKILL:
        _check_stop(nodes, ending, process, code, is_up, took_s)
    if ending.program == 'replay.py':
        _check_replay(nodes)
    return took_s


def _start(nodes: Nodes, ending: Ending) -> Process:
    if ending.program == 'demo':
        return nodes.start(
            sys.executable, os.path.join(ROOT, 'tools', 'demo.py'),
            os.path.join(ROOT, 'launch', 'demo.launch'), 'camera:=synthetic', 'world:=empty',
            'gui:=false', 'image_view:=false', 'web:=false', start_new_session=True)
    if ending.program == 'replay.py':
        film = os.path.join(nodes.folder, 'film.avi')
        if not os.path.exists(film):
            chain.write_film(film)
        return nodes.start_node('replay.py', film, '--output',
                                os.path.join(nodes.folder, 'replay'))
    return nodes.start_node(ending.program, *_NODES[ending.program][2:])


def _wait(nodes: Nodes, ending: Ending) -> Optional[wire.Subscription]:
    """Let the delay pass; return the subscription to the view, if it was possible."""
    end, view = time.monotonic() + ending.delay_s, None
    while time.monotonic() < end:
        if view is None and ending.viewed and ending.program == 'pybullet_sim.py':
            with contextlib.suppress(*wire.ERRORS):
                view = wire.Subscription(nodes.master_uri, '/gazebo', _VIEW, Image)
        time.sleep(min(0.05, max(0.0, end - time.monotonic())))
    return view


def _check_stop(nodes: Nodes, ending: Ending, process: Process, code: int, is_up: bool,
                took_s: float) -> None:
    """Raise AssertionError if a program did not end as it should, or left something."""
    text = 'exit code {}\n{}'.format(code, process.output[-2000:])
    if is_up:
        assert code == 0, text
        assert 'Traceback' not in process.output, text
        uri = None
        with contextlib.suppress(*wire.ERRORS):
            uri = wire.node_uri(nodes.master_uri, _NODES[ending.program][0])
        # it waits no longer for a master that is busy; its name stays then
        assert uri is None or took_s > lifecycle.END_LIMIT_S, (
            'it is still registered, at {}\n{}'.format(uri, text))
    assert nodes.temporary_files() == [], nodes.temporary_files()


def _check_replay(nodes: Nodes) -> None:
    """Run a replay to its end: it has to remove what a killed one has left."""
    done = nodes.start_node('replay.py', os.path.join(nodes.folder, 'film.avi'), '--output',
                            os.path.join(nodes.folder, 'replay'))
    code = done.wait()
    nodes.forget(done)
    assert code == 0, done.output[-2000:]
    left = [name for name in os.listdir(nodes.folder) if name.startswith('.')]
    assert left == [], left
    assert nodes.temporary_files() == [], nodes.temporary_files()
