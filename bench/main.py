"""Run the benchmarks of ./run bench; print tables, and write JSON to the given file."""
import json
import sys

import camera
import drawing
import growth
import page
import recognition
import robot_camera
import simulator
import start
import transport
from tqdm import tqdm

BENCHMARKS = {'start': start, 'simulator': simulator, 'drawing': drawing,
              'robot_camera': robot_camera, 'camera': camera, 'recognition': recognition,
              'growth': growth, 'transport': transport, 'page': page}


def main() -> int:
    """Run all benchmarks."""
    results = {}
    total = sum(benchmark.count() for benchmark in BENCHMARKS.values())
    with tqdm(total=total, desc='measuring', unit='measurement', file=sys.stderr) as bar:
        for name, benchmark in BENCHMARKS.items():
            results[name] = benchmark.measure(bar.update)
    with open(sys.argv[1], 'w') as file:
        json.dump(results, file, indent=2)
    for name, benchmark in BENCHMARKS.items():
        sys.stdout.write('\n' + benchmark.table(results[name]) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
