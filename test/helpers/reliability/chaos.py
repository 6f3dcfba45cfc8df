"""Chaos: breaks parts of a running demo at random and measures when everything works again."""
import argparse
import random
import sys
import time
from typing import Dict, Iterable, Iterator, List, Optional, Sequence

from img_recog.command_line.results import text_table
from img_recog_helpers import process_table
from img_recog_helpers.process_table import Usage
from img_recog_helpers.reliability import faults, figures
from img_recog_helpers.reliability import demo as demos
from img_recog_helpers.reliability.chain import ChainError
from img_recog_helpers.reliability.demo import (LIMIT_S, NODES, START_LIMIT_S, STOP_LIMIT_S, Demo,
                                                node_name)
from img_recog_helpers.reliability.faults import Fault
from img_recog_helpers.signals import handle_ignored_signals
from img_recog_helpers.waiting import wait_for

_SETTLE_S = 20.0            # until connections of before are gone
# more than at the start: connections differ from run to run, a leak grows with each fault
_EXTRA = {'threads': 10, 'descriptors': 10, 'rss_mb': 80.0}


class Chaos:
    """Applies faults to a demo, one after the other.

    times_s: for each kind, the seconds from the end of each fault until the chain worked.
    failures: a line for each fault that was not survived.
    """

    def __init__(self, demo: Demo, factor: float, say, all_colors: bool = True):
        """all_colors: whether to wait for the reaction to each color after each fault."""
        self._demo, self._factor, self._say, self._all_colors = demo, factor, say, all_colors
        self.times_s: Dict[str, List[float]] = {}
        self.failures: List[str] = []
        self._before: Dict[str, Usage] = {}
        self._files: List[str] = []

    def begin(self) -> None:
        """Wait for the demo, and remember what it uses."""
        self._demo.chain.wait(START_LIMIT_S * self._factor)
        self._before = wait_for(self._all_nodes, 'all nodes')
        self._files = self._demo.temporary_files()

    def apply(self, fault: Fault) -> bool:
        """Apply a fault; return whether everything works again within its time."""
        limit_s = LIMIT_S * self._factor
        try:
            with faults.APPLY[fault.kind](self._demo, fault) as begin:
                waited_s = time.monotonic() - begin
                recovered_s = waited_s + self._demo.chain.wait(
                    limit_s - waited_s, self._all_colors).recovered_s
            self.times_s.setdefault(fault.kind, []).append(recovered_s)
            wait_for(lambda: not self._leftovers(),
                     lambda: 'the end of: {}'.format('; '.join(self._leftovers())),
                     _SETTLE_S * self._factor)
        except (AssertionError, LookupError, OSError, ValueError, EOFError) as error:
            self.failures.append('{}: {}: {}'.format(fault, type(error).__name__, error))
            self._say('  FAILED {}'.format(self.failures[-1]))
            return False
        self._say('  {} {:.2f} s'.format(fault, recovered_s))
        return True

    def recover(self) -> bool:
        """After a failure, return whether the demo works at all, given more time."""
        try:
            self._demo.chain.wait(START_LIMIT_S * self._factor)
        except ChainError as error:
            self._say('  the demo does not come back: {}'.format(error))
            return False
        return True

    def _all_nodes(self) -> Optional[Dict[str, Usage]]:
        found = self._demo.usage()
        return found if set(found) == set(NODES) else None

    def _leftovers(self) -> List[str]:
        """Return a line for each thing that was not there at the start."""
        problems = ['{} runs {} times'.format(name, len(pids))
                    for name, pids in self._demo.pids().items() if len(pids) != 1]
        problems += ['process: ' + line
                     for line in process_table.marked(self._demo.marker).values()
                     if node_name(line) is None and not _belongs(line)]
        problems += demos.problems(self._before, self._demo.usage(), _EXTRA)
        new = sorted(set(self._demo.temporary_files()) - set(self._files))
        return problems + ['temporary file ' + name for name in new]


def _belongs(line: str) -> bool:
    return any(name in line for name in ('roslaunch', 'roscore', 'rosmaster', 'respawn.py'))


def drawn(seed: int, kinds: Sequence[str] = faults.KINDS) -> Iterator[Fault]:
    """Yield the faults of a seed, without end."""
    rng = random.Random(seed)
    while True:
        yield faults.draw(rng, tuple(kinds))


def run(sequence: Iterable[Fault], duration_s: float = float('inf'), factor: float = 1.0,
        say=print, arguments: Sequence[str] = ()) -> Chaos:
    """Apply faults to a new demo until they end or the time is over; return the result.

    say: is called with each line of progress.
    arguments: of the launch file.
    """
    with Demo() as demo:
        chaos = Chaos(demo, factor, say)
        try:
            demo.start_all(*arguments)
            chaos.begin()
            end = time.monotonic() + duration_s
            for fault in sequence:
                if time.monotonic() > end or not (chaos.apply(fault) or chaos.recover()):
                    break
            took_s = demo.stop(STOP_LIMIT_S * factor)
            chaos.times_s.setdefault('stop of the demo', []).append(took_s)
        except AssertionError as error:
            chaos.failures.append(str(error))
        if chaos.failures:
            say('last lines of the demo:\n' + demo.launch.output[-3000:])
    return chaos


def report(chaos: Chaos, factor: float) -> str:
    """Return the table of a run."""
    rows = [[kind, *figures.seconds(times_s),
             '{:g}'.format((LIMIT_S if kind in faults.KINDS else STOP_LIMIT_S) * factor)]
            for kind, times_s in sorted(chaos.times_s.items())]
    return '\n'.join(text_table(
        [['fault', 'count', 'median, s', 'maximum, s', 'limit, s'], *rows]))


def main(words: Optional[Sequence[str]] = None) -> int:
    """Run chaos from the command line; return the exit code."""
    parser = argparse.ArgumentParser(prog='./run chaos', description=__doc__)
    parser.add_argument('minutes', nargs='?', type=float, default=10.0,
                        help='how long, after the start of the demo (default: 10)')
    parser.add_argument('--seed', type=int, help='repeat the faults of this seed')
    parser.add_argument('--factor', type=float, default=1.0,
                        help='multiply all time limits, for a busy machine (default: 1)')
    parser.add_argument('--faults', type=int, help='stop after this number of faults')
    parser.add_argument('--only', action='append', choices=faults.KINDS,
                        help='only this kind of fault; can be repeated')
    options = parser.parse_args(words)
    seed = random.SystemRandom().randrange(1 << 32) if options.seed is None else options.seed
    handle_ignored_signals()
    repeat = ''.join(' --only ' + kind for kind in options.only or ())
    _say('chaos for {:g} min; repeat it with --seed {}{}'.format(options.minutes, seed, repeat))
    kinds = options.only or faults.possible()
    sequence = drawn(seed, kinds)
    if options.faults is not None:
        sequence = (fault for fault, _ in zip(sequence, range(options.faults)))
    chaos = run(sequence, options.minutes * 60, options.factor, _say)
    _say('\n{}\n'.format(report(chaos, options.factor)))
    for line in chaos.failures:
        _say('FAILED ' + line)
    count = sum(len(times_s) for times_s in chaos.times_s.values())
    _say('{}: {} measurements, {} failures, seed {}'.format(
        'failed' if chaos.failures else 'passed', count, len(chaos.failures), seed))
    return 1 if chaos.failures else 0


def _say(line: str) -> None:
    sys.stdout.write(line + '\n')
    sys.stdout.flush()


if __name__ == '__main__':
    sys.exit(main())
