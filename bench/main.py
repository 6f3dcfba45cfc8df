"""Run the benchmarks of ./run bench; print tables, and write JSON to the given file.

usage: main.py FILE [NAME ...], by default all benchmarks.
"""
import json
import sys

import camera
import drawing
import fitting
import fleet
import lockstep
import page
import recognition
import robot_camera
import simulator
import start
import sweep
import textured
import transport
from tqdm import tqdm

BENCHMARKS = {'start': start, 'simulator': simulator, 'drawing': drawing,
              'robot_camera': robot_camera, 'textured': textured, 'camera': camera,
              'recognition': recognition, 'transport': transport, 'page': page, 'fleet': fleet,
              'lockstep': lockstep, 'fitting': fitting, 'sweep': sweep}


def main() -> int:
    """Run the benchmarks; return the exit code."""
    names = sys.argv[2:] or list(BENCHMARKS)
    unknown = sorted(set(names) - set(BENCHMARKS))
    if unknown:
        sys.stderr.write('no benchmark {}; there are {}\n'.format(
            ', '.join(unknown), ', '.join(BENCHMARKS)))
        return 2
    chosen = {name: BENCHMARKS[name] for name in names}
    results = {}
    total = sum(benchmark.count() for benchmark in chosen.values())
    with tqdm(total=total, desc='measuring', unit='measurement', file=sys.stderr) as bar:
        for name, benchmark in chosen.items():
            results[name] = benchmark.measure(bar.update)
    with open(sys.argv[1], 'w') as file:
        json.dump(results, file, indent=2)
    for name, benchmark in chosen.items():
        sys.stdout.write('\n' + benchmark.table(results[name]) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
