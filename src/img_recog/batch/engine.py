"""Runs a function on many pieces of work; the results are in the order of the pieces.

A result depends on its piece alone, so the number of processes, and which of them run where,
make no difference. Each result is a file of the work folder as soon as it is known: an
interrupted run goes on from there.
"""
import contextlib
import logging
from typing import Any, Dict, Generator, Iterator, Mapping, NamedTuple, Sequence, Tuple

from tqdm import tqdm

from img_recog.batch.options import Options
from img_recog.batch.work import Done, Function, Piece, run_piece
from img_recog.batch.work_folder import WorkFolder
from img_recog.errors import UserError
from img_recog.processes.signals import Interrupts

_log = logging.getLogger(__name__)


class Outcome(NamedTuple):
    """The result of a piece, or in one line why there is none."""

    key: str
    value: Any = None
    problem: str = ''


# Files of the same content have results of one name; a problem names the file that it is of.
_Source = Tuple[str, Tuple[str, ...]]


def _source(piece: Piece, name: str) -> _Source:
    return name, tuple(piece.files)


class Outcomes:
    """The outcomes of pieces, in their order; each is read from its file when it is needed."""

    def __init__(self, work: WorkFolder, named: Sequence[Tuple[Piece, str]],
                 problems: Mapping['_Source', str]):
        """Take pieces with the names of their results, and the problems by `_source`."""
        self._work, self._named, self._problems = work, named, problems

    def problems(self) -> Iterator[Tuple[str, str]]:
        """Yield the key and the problem of each piece that has one; no result is read."""
        for piece, name in self._named:
            problem = self._problems.get(_source(piece, name))
            if problem is not None:
                yield piece.key, problem

    def remove(self) -> None:
        """Remove the results."""
        self._work.remove()

    def __iter__(self) -> Iterator[Outcome]:
        for piece, name in self._named:
            problem = self._problems.get(_source(piece, name))
            yield (Outcome(piece.key, self._work.read(name)) if problem is None
                   else Outcome(piece.key, problem=problem))


class Engine:
    """Runs pieces where options say; the processes stay for more pieces, until the `with` ends."""

    def __init__(self, options: Options, interrupts: Interrupts):
        self._options, self._interrupts = options, interrupts
        self._stack = contextlib.ExitStack()
        self._client: Any = None

    def __enter__(self) -> 'Engine':
        return self

    def __exit__(self, *error: Any) -> None:
        self._stack.close()

    @contextlib.contextmanager
    def outcomes(self, function: Function, pieces: Sequence[Piece], folder: str,
                 unit: str = ' runs', known: Sequence[Done] = ()) -> Iterator['Outcomes']:
        """Run `function(paths, *arguments)` for each piece; yield the outcomes, in the same order.

        A UserError, or any other exception, of a piece is its outcome.
        folder: for the results meanwhile. It is removed at the end of the `with`, and stays if
        that is left by an exception, or a piece may succeed another time; with options.resume, its
        results are used, else they are removed. unit: of the size of the pieces, for the
        progress. known: what has run already.
        Raises UserError if the pieces cannot be run or the results not be written.
        """
        work = WorkFolder(folder, function)
        if not self._options.resume:
            work.remove()
        named = [(piece, work.name_of(piece)) for piece in pieces]
        # a piece is known by itself: several may have the same key
        name_of = {id(piece): name for piece, name in named}
        problems: Dict[_Source, str] = {}
        is_lost = False

        def note(done: Done, name: str) -> None:
            nonlocal is_lost
            is_lost = is_lost or done.is_lost
            if done.problem:
                problems[_source(done.piece, name)] = done.problem
            else:
                work.write(name, done.content)
        for done in known:
            note(done, work.name_of(done.piece))
        waiting = [piece for piece, name in named
                   if _source(piece, name) not in problems and not work.has(name)]
        with self._interrupts.deferred():   # the destructor of tqdm fails after half a constructor
            total = sum(piece.size for piece in pieces)
            progress = tqdm(total=total, initial=total - sum(piece.size for piece in waiting),
                            unit=unit, disable=None)
        try:
            with progress, contextlib.closing(self._run(function, waiting)) as running:
                for done in running:
                    note(done, name_of[id(done.piece)])
                    progress.update(done.piece.size)
        except (KeyboardInterrupt, SystemExit, UserError):
            _say_what_is_kept(work, len(pieces))
            raise
        yield Outcomes(work, named, problems)
        if is_lost:
            _say_what_is_kept(work, len(pieces))
        else:
            work.remove()

    def _run(self, function: Function, pieces: Sequence[Piece]) -> Generator[Done, None, None]:
        """Run pieces, in any order."""
        jobs = min(self._options.jobs, len(pieces))
        if not pieces or not self._options.scheduler and jobs == 1:
            for piece in pieces:
                yield Done(piece, *run_piece(function, piece.files, (), piece.arguments))
            return
        # imported here because loading Dask takes time
        from img_recog.batch import cluster
        options = self._options._replace(jobs=jobs)
        if self._client is None:
            self._client = self._stack.enter_context(cluster.connected(options, self._interrupts))
        elif not options.scheduler:
            cluster.add_workers(self._client, jobs, self._interrupts)
        yield from cluster.completed(self._client, function, pieces, options)


def _say_what_is_kept(work: WorkFolder, count: int) -> None:
    done = work.count()
    if done:
        _log.warning('%d of %d pieces are done and kept in %s; go on with --resume', done, count,
                     work.path)
