"""The long tests: half an hour of hostile input, stops, kills and soak; ./run test --long.

Each part runs in a process of its own. The soak runs beside the others, if it is selected.
"""
import argparse
import os
import random
import sys
import threading
import time
import traceback
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Dict, List, Optional, Sequence, Tuple

from img_recog_testing.reliability import figures
from img_recog_testing.reliability.parts import PARTS, Options, Row
from img_recog_testing.signals import handle_ignored_signals

_ALONGSIDE = 'soak'
_TAIL = 4000            # characters of the error of a part that has failed


def say(line: str) -> None:
    sys.stdout.write(line + '\n')
    sys.stdout.flush()


def run_part(name: str, options: Options) -> Tuple[List[Row], str]:
    """Run one part in this process; return its rows, and its error or nothing."""
    try:
        return PARTS[name](options), ''
    except Exception:       # assertions too: whatever it is, the other parts go on
        return [], traceback.format_exc()


class Run:
    """Parts that run in processes of their own, and what they have found."""

    def __init__(self, options: Options):
        self._options = options
        self.rows: Dict[str, List[Row]] = {}
        self.failed: List[str] = []

    def part(self, name: str) -> None:
        """Run a part and keep its result."""
        begin = time.monotonic()
        say('{}: {}'.format(name, PARTS[name].__doc__))
        with ProcessPoolExecutor(1, get_context('spawn')) as pool:
            try:
                rows, error = pool.submit(run_part, name, self._options).result()
            except BrokenProcessPool:
                rows, error = [], 'it has ended without a result'
        self.rows[name] = rows
        say('{}: {} after {:.0f} s'.format(name, 'FAILED' if error else 'passed',
                                           time.monotonic() - begin))
        for row in rows:
            say('  {}: {}'.format(*row))
        if error:
            self.failed.append(name)
            say(error[-_TAIL:])

    def all(self, names: Sequence[str]) -> None:
        """Run the parts, one after the other, the soak beside them."""
        others = [name for name in names if name != _ALONGSIDE]
        soak = threading.Thread(target=self.part, args=(_ALONGSIDE,))
        if _ALONGSIDE in names:
            soak.start()
        for name in others:
            self.part(name)
        if _ALONGSIDE in names:
            soak.join()


def main(words: Optional[Sequence[str]] = None) -> int:
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
    given = parser.parse_args(words)
    unknown = sorted(set(given.parts) - set(PARTS))
    if unknown:
        parser.error('no part {}; parts are {}'.format(', '.join(unknown), ', '.join(PARTS)))
    seed = random.SystemRandom().randrange(1 << 32) if given.seed is None else given.seed
    options = Options(seed, given.scale, given.factor)
    handle_ignored_signals()
    say('seed {}; repeat a part with ./run test --long PART --seed {}'.format(seed, seed))
    begin = time.monotonic()
    run = Run(options)
    run.all(given.parts or list(PARTS))
    rows = [row for name in PARTS for row in run.rows.get(name, ())]
    say('\n{}\n'.format(figures.table(['test', 'result', 'limit'], rows)))
    say('{} after {:.0f} min, seed {}'.format(
        'FAILED: ' + ', '.join(run.failed) if run.failed else 'passed',
        (time.monotonic() - begin) / 60, seed))
    return 1 if run.failed else 0


if __name__ == '__main__':
    sys.exit(main())
