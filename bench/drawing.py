"""CPU and wall time of drawing an image, compared with PyBullet's."""
from functools import partial
from typing import Dict

from pairs import Benchmark, Column, Samples
from ros_processes import Sampler

TURNS, SECONDS = 7, 1.0
METHODS = ('img_recog', 'img_recog, depths', "PyBullet's EGL plugin")
SIZES = (320, 240), (640, 480), (1920, 1080)


def _turns(width: int, height: int) -> Samples:
    """Return what each method measures in each turn; nothing for one that is not available.

    All have loaded the scene before the first turn, and one draws at a time.
    """
    samplers: Dict[str, Sampler] = {}
    try:
        for method in METHODS:
            samplers[method] = Sampler('drawing_sample.py', method, str(width), str(height))
        found: Samples = {method: [] for method, sampler in samplers.items() if sampler.available}
        for _ in range(TURNS):
            for method, turns in found.items():
                turns.append(samplers[method].sample(SECONDS))
        return found
    finally:
        for sampler in samplers.values():
            sampler.close()


def benchmark() -> Benchmark:
    """Return what drawing costs."""
    return Benchmark('drawing', {
        '{}x{}'.format(*size): partial(_turns, *size) for size in SIZES}, (
            Column('CPU an image, ms', 'cpu_ms', has_ratio=True),
            Column('wall time, ms', 'wall_ms', has_ratio=True)), rounds=1)
