"""What programs with a command line, like replay.py and film.py, have in common."""
import logging
import os
import signal
import sys
from typing import Callable, List, Optional, Sequence

from img_recog.errors import UserError, named_in_crashes, one_line
from img_recog.processes.signals import Interrupts
from img_recog.recognition import parameter_file
from img_recog.recognition.settings import RecognitionSettings, with_colors


class _Lines(logging.Formatter):
    """Writes lines like those of argparse: "replay.py: error: ..."."""

    def __init__(self, program: str):
        super().__init__(program + ': %(levelname)s: %(message)s')

    def formatMessage(self, record: logging.LogRecord) -> str:
        levels = {**vars(record), 'levelname': record.levelname.lower()}
        return super().formatMessage(logging.makeLogRecord(levels))


class Incomplete(str):
    """The summary of a program that has done a part of its work; its exit code is 1."""


def run(name: str, program: Callable[[List[str], Interrupts], str], failed: str,
        words: Optional[Sequence[str]] = None) -> int:
    """Run a program, print the summary that it returns, and return the exit code.

    name: of the program, and of its log, which is in the terminal then. An error is one line of
    it; failed: its beginning, where the system names no file. An `Incomplete` summary is printed,
    too. words: by default those of the command line, also __name:=... and __log:=..., which
    roslaunch adds. The code is 1 at least if nobody reads what is printed.
    """
    return _flush(_run(name, program, failed, sys.argv[1:] if words is None else words))


def _run(name: str, program: Callable[[List[str], Interrupts], str], failed: str,
         words: Sequence[str]) -> int:
    handler = logging.StreamHandler()
    handler.setFormatter(_Lines(name))
    logging.basicConfig(handlers=[handler])
    log, interrupts = logging.getLogger(name), Interrupts()
    try:
        arguments = [word for word in words if not (word.startswith('__') and ':=' in word)]
        summary = named_in_crashes(' '.join([name, *arguments]), program, arguments, interrupts)
        sys.stdout.write(summary + '\n')
        return int(isinstance(summary, Incomplete))
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
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            # Python would try once more at its end, complain, and exit with 120
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())
            code = code or 1
    return code


def recognition_settings(path: str) -> RecognitionSettings:
    """Return the settings in a parameter file of color_extract; if empty, those of the article."""
    return parameter_file.read(os.path.expanduser(path)) if path else with_colors()()
