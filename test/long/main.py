#!/usr/bin/env python3
"""The long tests: half an hour of hostile input, stops, kills and soak; ./run test --long.

Each part runs in a process of its own. The soak runs beside the others, if it is selected.
"""
import argparse
import json
import os
import random
import subprocess
import sys
import tempfile
import threading
import time
import traceback

from img_recog_testing.reliability import figures
from img_recog_testing.reliability.parts import PARTS, Options
from img_recog_testing.signals import handle_ignored_signals

_ALONGSIDE = 'soak'
_TAIL = 4000            # characters of the output of a part that has failed


def say(line):
    sys.stdout.write(line + '\n')
    sys.stdout.flush()


def run_part(name, options, result_path):
    """Run one part in this process; write its rows or its error; return the exit code."""
    result = {'rows': [], 'error': ''}
    try:
        result['rows'] = PARTS[name](options)
    except Exception:       # assertions too: whatever it is, the other parts go on
        result['error'] = traceback.format_exc()
    with open(result_path, 'w') as file:
        json.dump(result, file)
    return 1 if result['error'] else 0


class Run:
    """Parts that run in processes of their own, and what they have found."""

    def __init__(self, options, folder):
        self._options, self._folder = options, folder
        self.rows, self.failed = {}, []

    def part(self, name):
        """Run a part and keep its result."""
        path, begin = os.path.join(self._folder, name + '.json'), time.monotonic()
        say('{}: {}'.format(name, PARTS[name].__doc__))
        with open(os.path.join(self._folder, name + '.log'), 'w+b') as log:
            subprocess.run([sys.executable, os.path.abspath(__file__), '--run-part', name, path,
                            '--seed', str(self._options.seed), '--scale',
                            str(self._options.scale), '--factor', str(self._options.factor)],
                           stdout=log, stderr=subprocess.STDOUT, check=False)
            log.seek(0)
            output = log.read().decode(errors='replace')
        try:
            with open(path) as file:
                result = json.load(file)
        except (OSError, ValueError):
            result = {'rows': [], 'error': 'it has ended without a result\n' + output}
        self.rows[name] = result['rows']
        say('{}: {} after {:.0f} s'.format(name, 'FAILED' if result['error'] else 'passed',
                                           time.monotonic() - begin))
        for row in result['rows']:
            say('  {}: {}'.format(*row))
        if result['error']:
            self.failed.append(name)
            say(result['error'][-_TAIL:])

    def all(self, names):
        """Run the parts, one after the other, the soak beside them."""
        others = [name for name in names if name != _ALONGSIDE]
        soak = threading.Thread(target=self.part, args=(_ALONGSIDE,))
        if _ALONGSIDE in names:
            soak.start()
        for name in others:
            self.part(name)
        if _ALONGSIDE in names:
            soak.join()


def main(words=None):
    """Run the selected parts; return the exit code."""
    parser = argparse.ArgumentParser(prog='./run test --long', description=__doc__)
    parser.add_argument('parts', nargs='*', metavar='PART',
                        help='{} (default: all)'.format(', '.join(PARTS)))
    parser.add_argument('--seed', type=int, help='repeat what this seed has done')
    parser.add_argument('--scale', type=float,
                        default=float(os.environ.get('IMG_RECOG_LONG_SCALE', '1')),
                        help='share of the full length, for a short trial '
                        '(default: IMG_RECOG_LONG_SCALE, or 1)')
    parser.add_argument('--factor', type=float, default=1.0,
                        help='multiply all time limits, for a busy machine (default: 1)')
    parser.add_argument('--run-part', nargs=2, help=argparse.SUPPRESS)
    given = parser.parse_args(words)
    unknown = sorted(set(given.parts) - set(PARTS))
    if unknown:
        parser.error('no part {}; parts are {}'.format(', '.join(unknown), ', '.join(PARTS)))
    seed = random.SystemRandom().randrange(1 << 32) if given.seed is None else given.seed
    options = Options(seed, given.scale, given.factor)
    if given.run_part:
        return run_part(*given.run_part[:1], options, given.run_part[1])
    handle_ignored_signals()
    say('seed {}; repeat a part with ./run test --long PART --seed {}'.format(seed, seed))
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix='img_recog_long_') as folder:
        run = Run(options, folder)
        run.all(given.parts or list(PARTS))
    rows = [row for name in PARTS for row in run.rows.get(name, ())]
    say('\n{}\n'.format(figures.table(['test', 'result', 'limit'], rows)))
    say('{} after {:.0f} min, seed {}'.format(
        'FAILED: ' + ', '.join(run.failed) if run.failed else 'passed',
        (time.monotonic() - begin) / 60, seed))
    return 1 if run.failed else 0


if __name__ == '__main__':
    sys.exit(main())
