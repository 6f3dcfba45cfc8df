"""The programs of the package: their command lines, their ends, and what they write."""
import argparse
import contextlib
import fcntl
import logging
import os
import signal
import sys
from typing import Any, Callable, List, Optional, Sequence, TextIO

from img_recog.errors import UserError, named_in_crashes, one_line
from img_recog.processes.signals import Interrupts

_data: Optional[TextIO] = None      # standard output, after `keep_for_data`


def allowed(kind: Callable[[str], Any], is_allowed: Callable[[Any], bool],
            expected: str) -> Callable[[str], Any]:
    """Return a type of which not all values are allowed.

    kind: makes a value of the text. expected: what is allowed, for the error.

    >>> allowed(float, lambda seconds: seconds > 0, 'a number above 0')('1.5')
    1.5
    """
    def value(text: str) -> Any:
        with contextlib.suppress(ValueError):
            if is_allowed(kind(text)):
                return kind(text)
        raise argparse.ArgumentTypeError('got {!r}, expected {}'.format(text, expected))
    return value


class _Lines(logging.Formatter):
    """Writes lines like those of argparse: "replay.py: error: ..."."""

    def __init__(self, program: str):
        super().__init__(program + ': %(levelname)s: %(message)s')

    def formatMessage(self, record: logging.LogRecord) -> str:
        levels = {**vars(record), 'levelname': record.levelname.lower()}
        return super().formatMessage(logging.makeLogRecord(levels))


class Incomplete(str):
    """The summary of a program that has not done all of its work.

    code: its exit code.
    """

    code = 1


def parser(name: str, description: str, **options: Any) -> argparse.ArgumentParser:
    """Return a parser of the command line of a program, whose options cannot be abbreviated."""
    return argparse.ArgumentParser(prog=name, description=description, allow_abbrev=False,
                                   **options)


def run(name: str, program: Callable[[List[str], Interrupts], str], failed: str = 'cannot write',
        words: Optional[Sequence[str]] = None) -> int:
    """Run a program, print the summary that it returns, and return the exit code.

    name: of the program, and of its log, which is in the terminal then. An error is one line of
    it; failed: its beginning, where the system names no file. An `Incomplete` summary is printed,
    too. words: by default those of the command line, also __name:=... and __log:=..., which
    roslaunch adds. The code is 1 at least if nobody reads what is printed.
    """
    return _flush(_run(name, program, failed, sys.argv[1:] if words is None else words))


def write(text: str) -> None:
    """Write lines to stdout; not all terminals can show Japanese."""
    stdout = _data or sys.stdout
    encoding = stdout.encoding or 'utf-8'
    stdout.write(text.encode(encoding, 'replace').decode(encoding) + '\n')


def keep_for_data() -> None:
    """Keep stdout for `write`: what else is printed goes to stderr, also by libraries in C.

    A program whose output other programs read calls this after it has read its command line.
    """
    global _data
    if sys.stdout is None or sys.stdout is not sys.__stdout__:      # a test reads it
        return
    sys.stdout.flush()
    # above 2: stderr may be closed
    _data = open(fcntl.fcntl(1, fcntl.F_DUPFD_CLOEXEC, 3), 'w', 1, sys.stdout.encoding)
    os.dup2(2 if sys.stderr else os.open(os.devnull, os.O_WRONLY), 1)


def _run(name: str, program: Callable[[List[str], Interrupts], str], failed: str,
         words: Sequence[str]) -> int:
    handler = logging.StreamHandler()
    handler.setFormatter(_Lines(name))
    logging.basicConfig(handlers=[handler])
    log, interrupts = logging.getLogger(name), Interrupts()
    try:
        arguments = [word for word in words if not (word.startswith('__') and ':=' in word)]
        summary = named_in_crashes(' '.join([name, *arguments]), program, arguments, interrupts)
        if summary:
            write(summary)
        return getattr(summary, 'code', 0)
    except UserError as error:
        log.error('%s', one_line(error))
        return 1
    except OSError as error:
        log.error('%s: %s', error.filename or failed, one_line(error))
        return 1
    except KeyboardInterrupt:
        return 128 + signal.SIGINT


def _flush(code: int) -> int:
    """Write out what stands in the buffers; return the exit code, 1 when nobody reads it."""
    for stream in filter(None, (_data, sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError:
            # Python would try once more at its end, complain, and exit with 120
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
            code = code or 1
    return code
