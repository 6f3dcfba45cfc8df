"""CPU time and latency of the recognition and of other implementations."""
import os
import sys
from functools import partial
from typing import Callable, Dict, Optional

from pairs import Benchmark, Column
from ros_processes import PACKAGE, Master, installed, run_script

TURNS, SECONDS = 3, 1.0         # turns of each node per round, seconds per turn
SIZES = ((640, 480), (1920, 1080))
IMAGES = ('blue_image', 'red_image')
COMMAND_TOPICS = ['cmd_vel']      # the results of a node that publishes Twists
# parameters of hsv_color_filter for the bounds, and the article's values
LIMITS = ('h_limit_min', 'h_limit_max', 's_limit_min', 's_limit_max', 'v_limit_min', 'v_limit_max')
FILTERS = {'blue': (50, 150, 100, 255, 100, 255), 'red': (150, 180, 100, 255, 150, 255)}


def script(*path: str, env: Optional[Dict[str, str]] = None) -> Callable[
        [Master, str, bool], tuple]:
    """Return a function that starts a recognition node, a Python script that publishes Twists."""
    def start(master: Master, name: str, viewed: bool) -> tuple:
        process = master.start(sys.executable, os.path.join(PACKAGE, *path),
                               '__ns:=/' + name, env=env)
        if viewed:
            master.watch(*('/{}/{}'.format(name, image) for image in IMAGES))
        return COMMAND_TOPICS, [process.pid]
    return start


def filters(master: Master, name: str, _viewed: bool) -> tuple:
    """Start two C++ filters, one per color; their results are images."""
    pids = []
    for color, limits in FILTERS.items():
        process = master.start(
            'rosrun', 'opencv_apps', 'hsv_color_filter', '__ns:=/' + name, '__name:=' + color,
            'image:=usb_cam/image_raw', *(
                '_{}:={}'.format(*pair) for pair in zip(LIMITS, limits)))
        pids.append(process.pid)
    return ['{}/image'.format(color) for color in FILTERS], pids


NODES = {'img_recog': script('scripts', 'color_img_recog.py'),
         'plain': script('bench', 'plain_color_node.py'), 'opencv_apps': filters}


def samples(nodes: dict, kind: str, size: tuple, viewed: bool, turns: int = TURNS,
            rates: bool = True) -> dict:
    """Return, for each node, what recognition_sample.py measures in each turn.

    nodes: a dict from name to the function that starts the node. All nodes run at the same time,
    each in a separate namespace, and images are sent to one node at a time.
    rates: whether to measure the highest rates too.
    """
    with Master() as master:
        ends = []
        for name, start in nodes.items():
            topics, pids = start(master, name, viewed)
            ends.append({'name': name, 'images': '/{}/usb_cam/image_raw'.format(name),
                         'results': ['/{}/{}'.format(name, topic) for topic in topics],
                         'has_image_results': topics != COMMAND_TOPICS, 'pids': pids})
        return run_script('recognition_sample.py', kind, *size, turns, SECONDS, int(rates),
                          ends, env=master.env)


def _case(kind: str, size: tuple, viewed: bool) -> dict:
    found = ['img_recog', 'plain'] + ['opencv_apps'] * (viewed and installed('opencv_apps'))
    return samples({node: NODES[node] for node in found}, kind, size, viewed)


def benchmark() -> Benchmark:
    """Return what a frame costs, alone and with a viewer of the images."""
    return Benchmark('recognition at 30 Hz', {
        '{} {}x{} {}'.format(kind, *size, 'viewed' if viewed else 'alone'):
            partial(_case, kind, size, viewed)
        for kind in ('film', 'noise') for size in SIZES for viewed in (False, True)}, (
            Column('CPU a frame, ms', 'cpu_ms', has_ratio=True),
            Column('latency, ms', 'latency_ms', has_ratio=True),
            Column('99 %', 'latency_99_ms'),
            Column('and transport', 'with_transport_ms', has_ratio=True),
            Column('highest rate, Hz', 'rate_hz', '{:.0f}', has_ratio=True),
            Column('lost', 'lost', '{:.0f}')))
