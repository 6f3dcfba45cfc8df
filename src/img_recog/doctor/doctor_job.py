"""The command line of doctor.py."""
import itertools
import sys
from typing import Callable, Iterator, List, Optional, Sequence

from img_recog.command_line import programs
from img_recog.command_line.messages import message
from img_recog.doctor import machine, running_system
from img_recog.doctor.machine import Fault

Check = Callable[[], Iterator[Fault]]


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Print what is wrong and what to do; return 1 if there is more than notes, else 0."""
    return programs.run('doctor.py', _check, words=arguments)


def _check(words: List[str], _: object) -> str:
    parser = programs.parser(
        'doctor.py', 'Say what is wrong with this computer and with the running system, and what '
        'to do. The exit code is 1 if something is wrong, else 0.')
    parser.add_argument('--machine', action='store_true',
                        help='check the computer alone, while nothing runs')
    checks: List[Check] = [*machine.CHECKS]
    if not parser.parse_args(words).machine:
        checks.append(running_system.check_running)
    counts = [0, 0]
    # one by one, as each check takes a while
    for found in dict.fromkeys(itertools.chain.from_iterable(check() for check in checks)):
        counts[found.is_note] += 1
        programs.write('{}: {}\n    {}\n'.format(
            message('note' if found.is_note else 'problem'), found.problem, found.advice))
        sys.stdout.flush()
    if not any(counts):
        return message('nothing is wrong')
    summary = message('problems: {}, notes: {}', *counts)
    return programs.Incomplete(summary) if counts[False] else summary
