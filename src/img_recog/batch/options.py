"""The options of the command line that all programs with many pieces of work have."""
import argparse
import os
from typing import NamedTuple

from img_recog.command_line.option_types import allowed
from img_recog.errors import UserError


class Options(NamedTuple):
    """Where the pieces run, and whether those of an interrupted run are used.

    jobs: processes on this machine; scheduler: address of a scheduler of Dask, '' for this
    machine; copy: whether the files are sent to its workers; resume: whether to go on.
    """

    jobs: int = 1
    scheduler: str = ''
    copy: bool = False
    resume: bool = False


def add_to(parser: argparse.ArgumentParser) -> None:
    """Add the options; `of` returns their values."""
    parser.add_argument('--jobs', type=allowed(int, lambda jobs: 1 <= jobs <= 1024,
                                               'a whole number from 1 to 1024'),
                        default=len(os.sched_getaffinity(0)), metavar='N',
                        help='processes on this machine (default: one a core)')
    parser.add_argument('--scheduler', default='', metavar='tcp://HOST:PORT',
                        help='run on the cluster of this scheduler of Dask, not on this machine')
    parser.add_argument('--copy', action='store_true',
                        help='send the files to the workers, which do not share a file system')
    parser.add_argument('--resume', action='store_true',
                        help='go on where an interrupted run with the same output has ended')


def of(options: argparse.Namespace) -> Options:
    """Return the options; raise UserError for some that make no sense together."""
    if options.copy and not options.scheduler:
        raise UserError('--copy is for the workers of a --scheduler, which is missing')
    return Options(options.jobs, options.scheduler, options.copy, options.resume)
