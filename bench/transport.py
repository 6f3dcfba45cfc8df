"""Gain of each part of ros/transport: nodes with all parts, and with one part switched off."""
from statistics import median
from typing import Callable, Dict

import recognition
import simulator

SWITCH = 'IMG_RECOG_PLAIN_ROSPY'
# values of the switch; '0': with all parts, '1': without any
FRAME_CASES = ('0', 'image_publisher', 'image_subscriber', 'direct_publisher', 'rosout', '1')
STEP_CASES = ('0', 'direct_publisher', 'own_time', '1')
SIZE, TURNS = (640, 480), 5     # size of the images; turns per case
ROUNDS = 5                      # rounds per case of the simulator
TITLES = {'0': 'with all parts', '1': 'plain rospy'}


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return 2 + ROUNDS * len(STEP_CASES)


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over all turns or rounds. Each of them measures every case.

    done: called after each measurement.
    """
    nodes = {'case_{}'.format(number): recognition.script(
        'scripts', 'color_img_recog.py', env={SWITCH: case})
        for number, case in enumerate(FRAME_CASES)}
    result: Dict[str, list] = {}
    for key, is_viewed in (('alone', False), ('viewed', True)):
        turns = recognition.samples(nodes, 'film', SIZE, is_viewed, TURNS, rates=False)
        for name, unit in (('cpu_ms', ''), ('latency_ms', '_latency')):
            result[key + unit] = rows({case: [turn[name] for turn in turns[node]]
                                       for case, node in zip(FRAME_CASES, nodes)})
        done()
    costs: Dict[str, list] = {case: [] for case in STEP_CASES}
    for _ in range(ROUNDS):
        for case in STEP_CASES:
            costs[case].append(median(turn[0]['step_us'] for turn in simulator.node(
                0.0, [simulator.ALL], {SWITCH: case})))
            done()
    return {**result, 'steps': rows(costs)}


def rows(values: Dict[str, list]) -> list:
    """Return, for each case, the median, and the ratio to the first case of the same turn."""
    first = next(iter(values.values()))
    result = []
    for case, found in values.items():
        ratios = sorted(value / base for value, base in zip(found, first))
        result.append({'case': case, 'value': median(found), 'ratio': median(ratios),
                       'ratio_min': ratios[0], 'ratio_max': ratios[-1]})
    return result


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = []
    for key, title, unit in (
            ('alone', 'color_extract, {}x{}, alone'.format(*SIZE), 'CPU a frame, ms'),
            ('alone_latency', 'the same', 'latency, ms'),
            ('viewed', 'color_extract, {}x{}, viewed'.format(*SIZE), 'CPU a frame, ms'),
            ('viewed_latency', 'the same', 'latency, ms'),
            ('steps', 'simulator, all topics subscribed', 'CPU a step, us')):
        lines.append('{:40} {:>16} {:>24}'.format(title, unit, 'to the first (min-max)'))
        for row in results[key]:
            name = TITLES.get(row['case'], 'plain ' + row['case'])
            lines.append('{:40} {value:16.2f} {ratio:12.3f} ({ratio_min:.2f}-{ratio_max:.2f})'
                         .format(name, **row))
    return '\n'.join(lines)
