"""CPU time and latency of the recognition and of other implementations."""
import json
import os
import sys
from statistics import median
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np
from pictures import COMMANDS
from ros_processes import HERE, Master, installed, run_script, wait_for

PACKAGE = os.path.dirname(HERE)
TURNS, SECONDS = 3, 1.0         # turns of each node per round, seconds per turn
ROUNDS = {'film': 3, 'noise': 1, 'card': 1}         # by the kind of the images
SIZES = ((640, 480), (1280, 720), (1920, 1080))
IMAGES = ('blue_image', 'red_image')
COMMAND_TOPICS = ['cmd_vel']      # the results of a node that publishes Twists
# parameters of hsv_color_filter for the bounds, and the article's values
LIMITS = ('h_limit_min', 'h_limit_max', 's_limit_min', 's_limit_max', 'v_limit_min', 'v_limit_max')
FILTERS = {'blue': (50, 150, 100, 255, 100, 255), 'red': (150, 180, 100, 255, 150, 255)}
KEYS = ('cpu_ms', 'latency_ms', 'with_transport_ms', 'rate_hz')


def script(*path: str, arguments: Sequence[str] = (), env: Optional[Dict[str, str]] = None
           ) -> Callable[[Master, str, bool], tuple]:
    """Return a function that starts a recognition node, a Python script that publishes Twists."""
    def start(master: Master, name: str, viewed: bool) -> tuple:
        process = master.start(sys.executable, os.path.join(PACKAGE, *path), *arguments,
                               '__ns:=/' + name, env=env)
        if viewed:
            images = ['/{}/{}'.format(name, image) for image in IMAGES]
            master.start(sys.executable, os.path.join(HERE, 'watch_images.py'), *images,
                         '__ns:=/' + name)
            wait_for(lambda: {topic for topic, _ in master.server.getSystemState()[1]}
                     >= set(images), 'the viewers')
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
         'plain': script('bench', 'plain_color_node.py'), 'opencv_apps': filters,
         'relay': script('bench', 'relay_node.py', arguments=[str(COMMANDS['film'])])}


class Case(NamedTuple):
    """Images that are sent to nodes; viewed: whether the images of the nodes are subscribed."""

    kind: str
    size: Tuple[int, int]
    viewed: bool
    nodes: Sequence[str]


def cases() -> List[Case]:
    """Return the cases."""
    found = installed('opencv_apps')
    return [Case(kind, size, viewed, ['img_recog', 'plain'] + ['opencv_apps'] * (viewed and found)
                 + ['relay'] * (viewed and kind == 'film'))
            for kind in ROUNDS for size in SIZES for viewed in (False, True)]


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return sum(ROUNDS[case.kind] for case in cases())


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
                          json.dumps(ends), env=master.env)


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over all turns. Each turn measures every node.

    done: called after each measurement.
    """
    rows = []
    for case in cases():
        found = {node: [] for node in case.nodes}
        for _ in range(ROUNDS[case.kind]):
            starts = {node: NODES[node] for node in case.nodes}
            for node, turns in samples(starts, *case[:3]).items():
                found[node] += turns
            done()
        for node in case.nodes:
            row = {'kind': case.kind, 'size': '{}x{}'.format(*case.size), 'viewed': case.viewed,
                   'node': node,
                   'lost': sum(each['lost'] for each in found[node]),
                   'latency_99_ms': float(np.percentile(np.concatenate(
                       [each['latencies_ms'] for each in found[node]]), 99))}
            for key in KEYS:
                row[key] = median(each[key] for each in found[node])
                # ratio within a turn: if the machine is slow for a while, it is slow for all nodes
                row['ours_to_' + key] = median(
                    ours[key] / theirs[key]
                    for ours, theirs in zip(found['img_recog'], found[node]))
            rows.append(row)
    return {'rows': rows}


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = ['{:<46} {:>14} {:>22} {:>14} {:>16}'.format(
        'recognition at 30 Hz; in brackets: ours to it', 'CPU a frame', 'latency, median (99 %)',
        'and transport', 'highest rate')]
    for row in results['rows']:
        title = '{} {} {}, {}'.format(row['kind'], row['size'],
                                      'viewed' if row['viewed'] else 'alone', row['node'])
        lines.append('{:<38} {cpu_ms:6.2f} ms ({ours_to_cpu_ms:.2f})  {latency_ms:6.2f} '
                     '({latency_99_ms:.2f}) ms ({ours_to_latency_ms:.2f})  '
                     '{with_transport_ms:6.2f} ms ({ours_to_with_transport_ms:.2f})  '
                     '{rate_hz:5.0f} Hz ({ours_to_rate_hz:.1f})'.format(title, **row))
    return '\n'.join(lines)
