"""Run the benchmarks of ./run bench; print tables, and write JSON to the given file.

usage: main.py FILE [NAME ...], by default all benchmarks. Ratios are in brackets: ours to it.
"""
import importlib
import json
import sys

import pairs
from tqdm import tqdm

NAMES = ('start', 'simulator', 'drawing', 'demo', 'camera', 'recognition', 'transport', 'page',
         'fleet', 'lockstep')


def main() -> int:
    """Run the benchmarks; return the exit code."""
    names = sys.argv[2:] or NAMES
    unknown = sorted(set(names) - set(NAMES))
    if unknown:
        sys.stderr.write('no benchmark {}; there are {}\n'.format(
            ', '.join(unknown), ', '.join(NAMES)))
        return 2
    chosen = {name: importlib.import_module(name).benchmark() for name in names}
    results = {}
    with tqdm(total=sum(each.rounds * len(each.groups) for each in chosen.values()),
              desc='measuring', file=sys.stderr) as bar:
        for name, benchmark in chosen.items():
            results[name] = pairs.measure(benchmark, bar.update)
    with open(sys.argv[1], 'w') as file:
        json.dump(results, file, indent=2)
    for name, benchmark in chosen.items():
        sys.stdout.write('\n' + pairs.table(benchmark, results[name]) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
