"""Run the benchmarks of ./run bench; print tables, and write JSON to the given file.

Ratios are in brackets: ours to it.
"""
import importlib
import json
import sys

import pairs
from tqdm import tqdm

from img_recog.command_line import programs

NAMES = ('start', 'simulator', 'drawing', 'demo', 'camera', 'recognition', 'transport', 'page',
         'fleet', 'lockstep')


def main() -> int:
    """Run the benchmarks; return the exit code."""
    parser = programs.parser('main.py', 'Run benchmarks, by default all.')
    parser.add_argument('file', metavar='FILE', help='of the numbers, JSON')
    parser.add_argument('names', metavar='NAME', nargs='*', help=', '.join(NAMES))
    given = parser.parse_args()
    unknown = sorted(set(given.names) - set(NAMES))
    if unknown:
        parser.error('no benchmark {}; there are {}'.format(
            ', '.join(unknown), ', '.join(NAMES)))
    chosen = {name: importlib.import_module(name).benchmark() for name in given.names or NAMES}
    results = {}
    with tqdm(total=sum(each.rounds * len(each.groups) for each in chosen.values()),
              desc='measuring', file=sys.stderr) as bar:
        for name, benchmark in chosen.items():
            results[name] = pairs.measure(benchmark, bar.update)
    with open(given.file, 'w') as file:
        json.dump(results, file, indent=2)
    for name, benchmark in chosen.items():
        sys.stdout.write('\n' + pairs.table(benchmark, results[name]) + '\n')
    return 0


if __name__ == '__main__':
    sys.exit(main())
