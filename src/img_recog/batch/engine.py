"""Runs a function on many pieces of work; the results are in the order of the pieces.

A result depends on its piece alone, so the number of processes, and which of them run where,
make no difference. Each result is a file of the work folder as soon as it is known: an
interrupted run goes on from there.
"""
import contextlib
import logging
from typing import Any, Dict, Generator, Iterator, Mapping, NamedTuple, Sequence

from tqdm import tqdm

from img_recog.batch.options import Options
from img_recog.batch.work import Done, Function, Piece, run_piece
from img_recog.batch.work_folder import WorkFolder
from img_recog.errors import UserError
from img_recog.signals import Interrupts

_log = logging.getLogger(__name__)


class Outcome(NamedTuple):
    """The result of a piece, or in one line why there is none."""

    key: str
    value: Any = None
    problem: str = ''


class Outcomes:
    """The outcomes of pieces, in their order; each is read from its file when it is needed."""

    def __init__(self, work: WorkFolder, names: Mapping[str, str], problems: Mapping[str, str]):
        """Take the name of the result of each key, and the problems of those that have none."""
        self._work, self._names, self._problems = work, names, problems

    def __iter__(self) -> Iterator[Outcome]:
        for key, name in self._names.items():
            yield (Outcome(key, problem=self._problems[key]) if key in self._problems
                   else Outcome(key, self._work.read(name)))


@contextlib.contextmanager
def outcomes(function: Function, pieces: Sequence[Piece], folder: str, options: Options,
             interrupts: Interrupts, unit: str = ' runs') -> Iterator['Outcomes']:
    """Run `function(paths, *arguments)` for each piece; yield the outcomes, in the same order.

    A UserError, or any other exception, of a piece is its outcome.
    folder: for the results meanwhile. It is removed at the end of the `with`, and stays if that is
    left by an exception or a piece has failed; with options.resume, its results are used, else
    they are removed. unit: of the size of the pieces, for the progress.
    Raises UserError if the pieces cannot be run or the results not be written.
    """
    work = WorkFolder(folder, function)
    if not options.resume:
        work.remove()
    names = [work.name_of(piece.files, piece.arguments) for piece in pieces]
    waiting = [piece for piece, name in zip(pieces, names) if not work.has(name)]
    name_of = {piece.key: name for piece, name in zip(pieces, names)}
    problems: Dict[str, str] = {}
    with interrupts.deferred():         # the destructor of tqdm fails after half a constructor
        total = sum(piece.size for piece in pieces)
        progress = tqdm(total=total, initial=total - sum(piece.size for piece in waiting),
                        unit=unit, disable=None)
    with progress, _says_what_is_kept(work, len(pieces)):
        with contextlib.closing(_run(function, waiting, options, interrupts)) as running:
            for done in running:
                if done.problem:
                    problems[done.piece.key] = done.problem
                else:
                    work.write(name_of[done.piece.key], done.content)
                progress.update(done.piece.size)
    yield Outcomes(work, name_of, problems)
    if not problems:
        work.remove()


@contextlib.contextmanager
def _says_what_is_kept(work: WorkFolder, count: int) -> Iterator[None]:
    try:
        yield
    except (KeyboardInterrupt, SystemExit, UserError):
        done = work.count()
        if done:
            _log.warning('%d of %d pieces are done and kept in %s; go on with --resume', done,
                         count, work.path)
        raise


def _run(function: Function, pieces: Sequence[Piece], options: Options,
         interrupts: Interrupts) -> Generator[Done, None, None]:
    """Run pieces, in any order."""
    jobs = min(options.jobs, len(pieces))
    if not pieces or not options.scheduler and jobs == 1:
        for piece in pieces:
            yield Done(piece, *run_piece(function, piece.files, (), piece.arguments))
        return
    # imported here because loading Dask takes time
    from img_recog.batch import cluster
    yield from cluster.run(function, pieces, options._replace(jobs=jobs), interrupts)
