"""CPU and wall time of drawing an image, compared with PyBullet's."""
import json
import os
import subprocess
import sys
from statistics import median
from typing import Callable, Dict

HERE = os.path.dirname(os.path.abspath(__file__))
TURNS, SECONDS = 7, 1.0
METHODS = ('img_recog', 'img_recog, depths', "PyBullet's EGL plugin")
CASES = (('robot', (320, 240)), ('robot', (640, 480)), ('robot', (1920, 1080)),
         ('above', (640, 480)))


class Sampler:
    """A running drawing_sample.py."""

    def __init__(self, method: str, viewpoint: str, width: int, height: int):
        self._process = subprocess.Popen(
            [sys.executable, os.path.join(HERE, 'drawing_sample.py'), method, viewpoint,
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


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return len(CASES)


def turns(viewpoint: str, width: int, height: int, number: int = TURNS) -> Dict[str, list]:
    """Return what each method measures in each turn; nothing for one that is not available.

    All have loaded the scene before the first turn, and one draws at a time.
    """
    samplers: Dict[str, Sampler] = {}
    try:
        for method in METHODS:
            samplers[method] = Sampler(method, viewpoint, width, height)
        found: Dict[str, list] = {method: [] for method in METHODS}
        for _ in range(number):
            for method, sampler in samplers.items():
                if sampler.available:
                    found[method].append(sampler.sample())
        return found
    finally:
        for sampler in samplers.values():
            sampler.close()


def measure(done: Callable[[], None]) -> dict:
    """Return the medians over all turns. Each turn measures every method.

    done: called after each measurement.
    """
    rows = []
    for viewpoint, size in CASES:
        found = turns(viewpoint, *size)
        done()
        for method, samples in found.items():
            row = {'viewpoint': viewpoint, 'size': '{}x{}'.format(*size), 'method': method,
                   'available': bool(samples)}
            for key in ('cpu_ms', 'wall_ms') if samples else ():
                row[key] = median(sample[key] for sample in samples)
                # ratio within a turn: if the machine is slow for a while, it is slow for all
                row['ours_to_' + key] = median(
                    ours[key] / theirs[key] for ours, theirs in zip(found['img_recog'], samples))
            rows.append(row)
    return {'rows': rows}


def table(results: dict) -> str:
    """Return the results as a table."""
    lines = ['{:<50} {:>18} {:>18}'.format('drawing; in brackets: ours to it', 'CPU an image',
                                           'wall time')]
    for row in results['rows']:
        title = '{} {}, {}'.format(row['viewpoint'], row['size'], row['method'])
        if row['available']:
            lines.append('{:<50} {cpu_ms:8.2f} ms ({ours_to_cpu_ms:.3f}) {wall_ms:8.2f} ms '
                         '({ours_to_wall_ms:.3f})'.format(title, **row))
        else:
            lines.append('{:<50} not available'.format(title))
    return '\n'.join(lines)
