"""Runs functions on many pieces of work; the results are in the order of the pieces.

A result depends on its piece alone, so the number of processes, and which of them run where,
make no difference. Each result is a file of the work folder as soon as it is known: an
interrupted run goes on from there.
"""
import argparse
import contextlib
import logging
import os
from types import MappingProxyType
from typing import (Any, Dict, Generator, Iterable, Iterator, Mapping, Optional, Sequence,
                    Tuple)

from tqdm import tqdm

from img_recog.batch.work import Done, Function, Piece, run_piece
from img_recog.batch.work_folder import WorkFolder, identity, lock
from img_recog.command_line.programs import allowed
from img_recog.errors import UserError
from img_recog.processes.signals import Interrupts

_log = logging.getLogger(__name__)


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of an Engine: where the pieces run, and whether an earlier run goes on."""
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


class Results:
    """The results of pieces, in their order; each is read from its file when it is needed."""

    def __init__(self, work: WorkFolder, names: Sequence[Tuple[Piece, str]],
                 problems: Dict[str, str]):
        """names: of the results of pieces; problems: of keys, in any stage."""
        self._work, self._names, self._problems = work, names, problems

    def __iter__(self) -> Iterator[Tuple[Piece, Any]]:
        """Yield each piece with its result, without those of keys that have a problem."""
        return ((piece, self._work.read(name)) for piece, name in self._names
                if piece.key not in self._problems)


class Engine:
    """Runs pieces where the options of `add_options` say, one stage after the other.

    The processes and the results stay until the `with` ends. The results also stay after it, for
    options.resume, if it is left by an exception or a piece may succeed another time. No other
    Engine has the same output meanwhile. A file that changes meanwhile is a UserError: each result
    is of the files as they were when they were first read.
    problems: why the pieces of a key cannot be used, the first reason.
    """

    def __init__(self, options: argparse.Namespace, interrupts: Interrupts, output: str,
                 log: Optional[logging.Logger] = None):
        """output: the results are in the folder `output`.work meanwhile.

        log: where each problem is said at once. Raises UserError for options that make no sense.
        """
        if options.copy and not options.scheduler:
            raise UserError('--copy is for the workers of a --scheduler, which is missing')
        self._options, self._interrupts = options, interrupts
        self._folder, self._problem_log = output + '.work', log
        self._stack = contextlib.ExitStack()
        self._client: Any = None
        self._work: Optional[WorkFolder] = None
        self._count = 0         # of pieces, of all stages
        self._is_lost = False
        self._read: Dict[str, str] = {}     # the identity of each file when it was first read
        self.problems: Dict[str, str] = {}

    def __enter__(self) -> 'Engine':
        self._lock = lock(self._folder)
        return self

    def __exit__(self, kind: Any, *_: Any) -> None:
        self._stack.close()
        done = self._work.count() if self._work else 0
        if kind is None and not self._is_lost or not done:
            self._forget()
        else:
            _log.warning('%d of %d pieces are done and kept in %s; go on with --resume', done,
                         self._count, self._folder)
        with contextlib.suppress(OSError):      # it has results, or files of the user
            os.rmdir(self._folder)
        os.close(self._lock)

    def _forget(self) -> None:
        if self._work is not None:
            self._work.remove()

    @contextlib.contextmanager
    def judging(self) -> Iterator[None]:
        """Keep no results if a UserError is raised: they are right, and what they say is it."""
        try:
            yield
        except UserError:
            self._forget()
            raise

    def watch(self, paths: Iterable[str],
              read: Mapping[str, str] = MappingProxyType({})) -> None:
        """Note files that are read from now on, or raise UserError if one has changed since then.

        read: the `identity` of those that were read before.
        """
        for path in paths:
            found = identity(path)
            if self._read.setdefault(path, read.get(path, found)) != found:
                raise UserError('{} has changed since it was read first'.format(path),
                                'go on with --resume, which repeats what depends on the file, or '
                                'start again')

    def run(self, function: Function, pieces: Sequence[Piece], unit: str = ' runs') -> Results:
        """Run `function(paths, *arguments)` for each piece; return the results.

        A UserError, or any other exception, of a piece is its problem. unit: of the size of the
        pieces, for the progress.
        Raises UserError if the pieces cannot be run or the results not be written.
        """
        work = WorkFolder(self._folder, function)
        if self._work is None and not self._options.resume:
            work.remove()
        self._work = work
        self._count += len(pieces)
        self.watch({path for piece in pieces for path in piece.files})
        for read in {id(piece.read): piece.read for piece in pieces}.values():
            self.watch(read, read)
        # a piece is known by itself: several may have the same key, or results of the same name
        names = {id(piece): work.name_of(piece) for piece in pieces}
        problems: Dict[int, str] = {}
        waiting = [piece for piece in pieces if not work.has(names[id(piece)])]
        with self._interrupts.deferred():   # the destructor of tqdm fails after half a constructor
            total = sum(piece.size for piece in pieces)
            progress = tqdm(total=total, initial=total - sum(piece.size for piece in waiting),
                            unit=unit, disable=None if pieces else True)
        with progress, contextlib.closing(self._done(function, waiting)) as running:
            for done in running:
                self._is_lost = self._is_lost or done.is_lost
                self.watch((*done.piece.files, *done.piece.read))
                if done.problem:
                    problems[id(done.piece)] = done.problem
                else:
                    work.write(names[id(done.piece)], done.result)
                progress.update(done.piece.size)
        for piece in pieces:
            if id(piece) in problems and piece.key not in self.problems:
                self.problems[piece.key] = problems[id(piece)]
                if self._problem_log:
                    self._problem_log.error('%s: %s', piece.key, problems[id(piece)])
        return Results(work, [(piece, names[id(piece)]) for piece in pieces], self.problems)

    def _done(self, function: Function, pieces: Sequence[Piece]) -> Generator[Done, None, None]:
        """Run pieces, in any order."""
        options = self._options
        if not pieces or not options.scheduler and min(options.jobs, len(pieces)) == 1:
            for piece in pieces:
                yield Done(piece, *run_piece(function, piece.files, (), piece.arguments))
            return
        # imported here because loading Dask takes time
        from img_recog.batch import cluster
        if self._client is None:
            self._client = self._stack.enter_context(cluster.connected(options, self._interrupts))
        yield from cluster.completed(self._client, function, pieces, options)
