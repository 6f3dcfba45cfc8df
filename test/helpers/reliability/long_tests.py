"""The long tests: half an hour of hostile input, stops, kills and soak; ./run test --long.

Each part runs in a process of its own. The soak runs beside the others, if it is selected.
"""
import argparse
import random
import sys
import time
import traceback
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import List, Optional, Sequence, Tuple

from img_recog.command_line.results import text_table
from img_recog_helpers.reliability.parts import PARTS, Options, Row
from img_recog_helpers.signals import handle_ignored_signals

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


def in_process(name: str, options: Options) -> Tuple[List[Row], str]:
    """Run one part in a separate process, and print how it went; return its rows and error."""
    begin = time.monotonic()
    say('{}: {}'.format(name, PARTS[name].__doc__))
    with ProcessPoolExecutor(1, get_context('spawn')) as pool:
        try:
            rows, error = pool.submit(run_part, name, options).result()
        except BrokenProcessPool:
            rows, error = [], 'it has ended without a result'
    say('{}: {} after {:.0f} s'.format(name, 'FAILED' if error else 'passed',
                                       time.monotonic() - begin))
    for row in rows:
        say('  {}: {}'.format(*row))
    if error:
        say(error[-_TAIL:])
    return rows, error


def main(words: Optional[Sequence[str]] = None) -> int:
    """Run the selected parts; return the exit code."""
    parser = argparse.ArgumentParser(prog='./run test --long', description=__doc__)
    parser.add_argument('parts', nargs='*', metavar='PART',
                        help='{} (default: all)'.format(', '.join(PARTS)))
    parser.add_argument('--seed', type=int, help='repeat what this seed has done')
    parser.add_argument('--scale', type=float, default=1.0,
                        help='share of the full length, for a short trial (default: 1)')
    parser.add_argument('--factor', type=float, default=1.0,
                        help='multiply all time limits, for a busy machine (default: 1)')
    parser.add_argument('--side-by-side', type=int, default=8, metavar='N',
                        help='simulations of the part lockstep at the same time (default: 8)')
    given = parser.parse_args(words)
    unknown = sorted(set(given.parts) - set(PARTS))
    if unknown:
        parser.error('no part {}; parts are {}'.format(', '.join(unknown), ', '.join(PARTS)))
    seed = random.SystemRandom().randrange(1 << 32) if given.seed is None else given.seed
    options = Options(seed, given.scale, given.factor, given.side_by_side)
    handle_ignored_signals()
    say('seed {}; repeat a part with ./run test --long PART --seed {}'.format(seed, seed))
    begin = time.monotonic()
    names = [name for name in PARTS if name in (given.parts or PARTS)]
    with ThreadPoolExecutor(1) as pool:         # the soak is beside the others
        soak = [pool.submit(in_process, name, options) for name in names if name == _ALONGSIDE]
        results = {name: in_process(name, options) for name in names if name != _ALONGSIDE}
        results.update({_ALONGSIDE: each.result() for each in soak})
    failed = [name for name in names if results[name][1]]
    say('\n{}\n'.format('\n'.join(text_table([
        ('test', 'result', 'limit'), *(row for name in names for row in results[name][0])]))))
    say('{} after {:.0f} min, seed {}'.format(
        'FAILED: ' + ', '.join(failed) if failed else 'passed', (time.monotonic() - begin) / 60,
        seed))
    return 1 if failed else 0


if __name__ == '__main__':
    sys.exit(main())
