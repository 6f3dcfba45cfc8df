"""Work on recordings in stages: one that cannot be used is named once, and the others count."""
import contextlib
import functools
import logging
from typing import Any, Dict, Iterator, List, Mapping, NamedTuple, Sequence, Tuple

from img_recog.batch.engine import Engine, Outcomes
from img_recog.batch.work import Function, Piece
from img_recog.errors import UserError
from img_recog.recordings import parts
from img_recog.recordings.frames import Part, Remarks


class Divided(NamedTuple):
    """The parts of a recording; start_ns: the stamp of its first usable frame."""

    parts: List[Part]
    start_ns: int


def divide(paths: Sequence[str], topic: str, max_pixels: int) -> Divided:
    """Return the parts of a recording that has a usable image; for the engine."""
    divided = parts.divide(paths[0], topic, max_pixels=max_pixels)
    return Divided(divided, parts.first(paths[0], divided, max_pixels).stamp_ns)


class Results:
    """The results of a stage, of the recordings that can be used; may be read several times."""

    def __init__(self, pieces: Sequence[Piece], outcomes: Outcomes, problems: Mapping[str, str]):
        self._pieces, self._outcomes, self._problems = pieces, outcomes, problems

    def __iter__(self) -> Iterator[Tuple[Piece, Any]]:
        """Yield each piece with its result."""
        return ((piece, outcome.value) for piece, outcome in zip(self._pieces, self._outcomes)
                if piece.key not in self._problems)


class Stages:
    """Runs pieces one stage after the other; their results stay until the `with` ends.

    The key of a piece is the name of its recording. problems: why recordings cannot be used;
    remarks: a line for each thing to be said of the others.
    """

    def __init__(self, engine: Engine, output: str, log: logging.Logger):
        """output: beginning of the paths of the folders for results."""
        self._engine, self._output, self._log = engine, output, log
        self._stack = contextlib.ExitStack()
        self._outcomes: List[Outcomes] = []
        self.problems: Dict[str, str] = {}
        self.remarks: List[str] = []

    def __enter__(self) -> 'Stages':
        return self

    def __exit__(self, *error: Any) -> Any:
        return self._stack.__exit__(*error)

    def run(self, function: Function, pieces: Sequence[Piece], unit: str) -> Results:
        """Run the pieces of recordings; log why some cannot be used."""
        outcomes = self._stack.enter_context(self._engine.outcomes(
            function, pieces, '{}.{}.work'.format(self._output, function.__name__), unit))
        self._outcomes.append(outcomes)
        for name, problem in outcomes.problems():
            if name not in self.problems:
                self.problems[name] = problem
                self._log.error('%s: %s', name, problem)
        return Results(pieces, outcomes, self.problems)

    def note(self, remarks: Mapping[str, Sequence[Remarks]]) -> None:
        """Log what is to be said of recordings; remarks: on their parts."""
        self.remarks = ['{}: {}'.format(name, line) for name, each in remarks.items()
                        for line in functools.reduce(Remarks.plus, each).lines(name)]
        for line in self.remarks:
            self._log.warning('%s', line)

    @contextlib.contextmanager
    def judging(self) -> Iterator[None]:
        """Keep no results if a UserError is raised: they are right, and what they say is it."""
        try:
            yield
        except UserError:
            for each in self._outcomes:
                each.remove()
            raise

    def lines(self) -> List[str]:
        """Return the part of a report on what could not be used, in Markdown."""
        lines = ['{}: {}'.format(*each) for each in self.problems.items()] + self.remarks
        return ['', 'Not used:', '', *('- ' + line for line in lines)] if lines else []
