"""Gain of each part of ros/transport: nodes with all parts, and with one part switched off."""
import recognition
import simulator
from pairs import Benchmark, Column, Samples

SWITCH = 'IMG_RECOG_PLAIN_ROSPY'
# values of the switch; '0': with all parts, '1': without any
FRAME_CASES = ('0', 'image_publisher', 'image_subscriber', 'direct_publisher', 'rosout', '1')
STEP_CASES = ('0', 'direct_publisher', 'own_time', '1')
SIZE, TURNS = (640, 480), 5
TITLES = {'0': 'with all parts', '1': 'plain rospy'}


def _title(case: str) -> str:
    return TITLES.get(case, 'plain ' + case)


def _frames(is_viewed: bool) -> Samples:
    nodes = {'case_{}'.format(number): recognition.script(
        'scripts', 'color_img_recog.py', env={SWITCH: case})
        for number, case in enumerate(FRAME_CASES)}
    found = recognition.samples(nodes, 'film', SIZE, is_viewed, TURNS, rates=False)
    return {_title(case): found[node] for case, node in zip(FRAME_CASES, nodes)}


def _steps() -> Samples:
    found = {}
    for case in STEP_CASES:
        found[_title(case)], = simulator.node(0.0, simulator.ALL, {SWITCH: case}).values()
    return found


def benchmark() -> Benchmark:
    """Return what the parts gain."""
    return Benchmark('gain of the parts of ros/transport', {
        'color_extract alone': lambda: _frames(False),
        'color_extract viewed': lambda: _frames(True), 'simulator': _steps}, (
            Column('CPU a frame, ms', 'cpu_ms', has_ratio=True),
            Column('latency, ms', 'latency_ms', has_ratio=True),
            Column('CPU a step, us', 'step_us', '{:.1f}', has_ratio=True)))
