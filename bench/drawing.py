"""CPU and wall time of drawing an image, compared with PyBullet's."""
import json
import os
import subprocess
import sys
from functools import partial
from typing import Dict

from pairs import Benchmark, Column, Samples
from ros_processes import HERE

TURNS, SECONDS = 7, 1.0
METHODS = ('img_recog', 'img_recog, depths', "PyBullet's EGL plugin")
SIZES = (320, 240), (640, 480), (1920, 1080)


class Sampler:
    """A running drawing_sample.py."""

    def __init__(self, method: str, width: int, height: int):
        self._process = subprocess.Popen(
            [sys.executable, os.path.join(HERE, 'drawing_sample.py'), method,
             str(width), str(height)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL, universal_newlines=True)
        # PyBullet writes to the standard output too
        self.available = any(line == 'ready\n' for line in iter(self._read, ''))

    def _read(self) -> str:
        return self._process.stdout.readline()

    def sample(self) -> dict:
        """Let it draw for SECONDS; return what it has measured."""
        self._process.stdin.write('{}\n'.format(SECONDS))
        self._process.stdin.flush()
        return json.loads(self._read())

    def close(self) -> None:
        """End it."""
        self._process.stdin.close()
        self._process.stdout.read()     # PyBullet writes when it ends
        self._process.stdout.close()
        self._process.wait()


def _turns(width: int, height: int) -> Samples:
    """Return what each method measures in each turn; nothing for one that is not available.

    All have loaded the scene before the first turn, and one draws at a time.
    """
    samplers: Dict[str, Sampler] = {}
    try:
        for method in METHODS:
            samplers[method] = Sampler(method, width, height)
        found: Samples = {method: [] for method, sampler in samplers.items() if sampler.available}
        for _ in range(TURNS):
            for method, turns in found.items():
                turns.append(samplers[method].sample())
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
