"""Closed loops of sweep.py by one process and two, and by replay.py; and what two cores give.

The last is a bare loop of Python, alone and two side by side: no engine can do better.
"""
import os
import resource
import subprocess
import sys
import tempfile
import time
from statistics import median
from typing import Callable, Dict, List

from ros_processes import HERE, run_script

LOOPS, SECONDS, RUNS = 4, 10.0, 3      # loops of a measurement, simulated time of each
BARE = 'bare loop'
_SCRIPT = os.path.join(os.path.dirname(HERE), 'scripts', 'replay.py')
_REPLAY = (_SCRIPT, '--camera', 'robot', '--seconds', str(SECONDS), '--world', 'color_posts',
           '--colors', os.path.join(os.path.dirname(HERE), 'config', 'follow.yaml'), '--no-teleop')
_BARE = '-c', 'x = 0\nfor number in range(60000000): x += number'


def _side_by_side(arguments: tuple, processes: int) -> dict:
    """Return the time of processes that do the same, for each time that it is done."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin_s = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        started = [subprocess.Popen([sys.executable, *arguments], cwd=folder,
                                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                   for _ in range(processes)]
        if any(process.wait() for process in started):
            raise RuntimeError('{} has failed'.format(arguments[0]))
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return {'wall_s': (time.perf_counter() - begin_s) / processes,
            'cpu_s': (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)
            / processes}


def _sweep(jobs: int) -> dict:
    found = run_script('sweep_sample.py', jobs, LOOPS, SECONDS)
    return {key: value / LOOPS for key, value in found.items()}


WAYS: Dict[str, Callable[[], dict]] = {
    BARE: lambda: _side_by_side(_BARE, 1),
    BARE + ', two processes': lambda: _side_by_side(_BARE, 2),
    'replay.py': lambda: _side_by_side(_REPLAY, 1),
    'sweep.py, one process': lambda: _sweep(1),
    'sweep.py, two processes': lambda: _sweep(2)}


def count() -> int:
    """Return the number of measurements that `measure` makes."""
    return RUNS * len(WAYS)


def measure(done: Callable[[], None]) -> dict:
    """Return the median wall and CPU time of a loop, s; done: called after each measurement."""
    found: Dict[str, List[dict]] = {way: [] for way in WAYS}
    for _ in range(RUNS):
        for way, run in WAYS.items():
            found[way].append(run())
            done()
    return {'rows': [{'way': way, **{key: median(each[key] for each in times)
                                     for key in ('wall_s', 'cpu_s')}}
                     for way, times in found.items()]}


def table(results: dict) -> str:
    """Return the results as a table."""
    return '\n'.join(
        ['Closed loops of {:g} s, camera of 640x480 pixels at 30 Hz'.format(SECONDS),
         '{:<36} {:>13} {:>13}'.format('', 'time a loop', 'CPU a loop'),
         *('{way:<36} {wall_s:>11.2f} s {cpu_s:>11.2f} s'.format(**row)
           for row in results['rows'])])
