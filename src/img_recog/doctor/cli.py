"""The command line of doctor.py."""
import argparse
import itertools
import sys
from typing import Callable, Iterator, List, Optional, Sequence

from img_recog.command_line.messages import message
from img_recog.doctor import machine, running
from img_recog.doctor.machine import Finding

Check = Callable[[], Iterator[Finding]]


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Print what is wrong and what to do; return 1 if there is more than notes, else 0."""
    parser = argparse.ArgumentParser(
        prog='doctor.py', description='Say what is wrong with this computer and with the running '
        'system, and what to do. The exit code is 1 if something is wrong, else 0.')
    parser.add_argument('--machine', action='store_true',
                        help='check the computer alone, while nothing runs')
    options = parser.parse_args(arguments)
    checks: List[Check] = [*machine.CHECKS]
    if not options.machine:
        checks.append(running.check_running)
    counts = [0, 0]
    # one by one, as each check takes a while
    for found in dict.fromkeys(itertools.chain.from_iterable(check() for check in checks)):
        counts[found.is_note] += 1
        _write(_text(found))
    _write(message('problems: {}, notes: {}', *counts) if any(counts) else
           message('nothing is wrong'))
    return 1 if counts[False] else 0


def _text(found: Finding) -> str:
    kind = message('note') if found.is_note else message('problem')
    return '{}: {}\n    {}\n'.format(kind, found.problem, found.advice)


def _write(text: str) -> None:
    # not all terminals can show Japanese
    sys.stdout.buffer.write((text + '\n').encode(sys.stdout.encoding or 'utf-8', 'replace'))
    sys.stdout.buffer.flush()
