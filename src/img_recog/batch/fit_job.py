"""The program fit_colors: finds the bounds of colors that separate them best in recordings."""
import argparse
import logging
import os
import sys
from typing import Any, Dict, Iterable, Iterator, List, NamedTuple, Optional, Sequence, Set, Tuple

from img_recog import files
from img_recog.batch import fit_pieces
from img_recog.batch import options as batch_options
from img_recog.batch.engine import Engine, Outcome
from img_recog.batch.fit_options import parse
from img_recog.batch.fit_pieces import FIT, Source
from img_recog.batch.fit_report import Refused, Report
from img_recog.batch.fit_settings import BaseSettings
from img_recog.batch.work import Piece
from img_recog.errors import UserError, one_line
from img_recog.recognition.fitting import bounds, sample_file, samples
from img_recog.recognition.fitting.bounds import Fit
from img_recog.recognition.fitting.histograms import Counter, Histograms, is_by_times, of_color
from img_recog.recognition.fitting.limits import BLOB_SIZES
from img_recog.recognition.fitting.samples import SampleError, Samples
from img_recog.recordings import names, parts
from img_recog.recordings.frames import Remarks
from img_recog.replay import programs
from img_recog.signals import Interrupts

_log = logging.getLogger('fit_colors.py')


class Recorded(NamedTuple):
    """A part of a recording; key: its name in reports."""

    key: str
    path: str
    source: Source


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the program; return its exit code."""
    return programs.run('fit_colors.py', _run, 'cannot fit the colors', arguments)


def _run(arguments: List[str], interrupts: Interrupts) -> str:
    options = parse(arguments)
    paths = names.expand(options.recordings, _log.warning)
    sets = [sample_file.read(path) for path in (options.samples, options.check) if path]
    sets[FIT].check_colors()
    for each in sets:
        each.check_recordings(paths)
    if options.check:
        _check_colors(*sets)
    if not os.path.isdir(os.path.dirname(options.output) or '.'):
        raise UserError('cannot write {}: no such folder'.format(options.output),
                        'make it, or set --output to another')
    report = Report(options.output, sets, paths, options.objective)
    for path in [*paths, options.samples, options.check, options.colors]:
        for output in report.paths:
            files.refuse_input(output, path, 'read', 'set --output to another')
    with Engine(batch_options.of(options), interrupts) as engine:
        fitting = _Fitting(options, sets, paths, engine)
        summary = fitting.run(report)
    if fitting.broken:
        sys.stdout.write(summary + '\n')
        raise UserError('{} of {} recordings cannot be read, and the others count: {}'.format(
            len(fitting.broken), len(paths), '; '.join(fitting.broken.values())))
    return summary


def _check_colors(fit: Samples, check: Samples) -> None:
    for color in check.colors:
        if color not in fit.colors:
            raise SampleError('{}: there is no color {}; those of {} are {}'.format(
                check.path, color, fit.path, ', '.join(fit.colors)))


class _Fitting:
    """A run of the program.

    broken: why recordings cannot be read; remarks: on the others.
    """

    def __init__(self, options: argparse.Namespace, sets: Sequence[Samples],
                 paths: Sequence[str], engine: Engine):
        self._options, self._sets, self._engine = options, sets, engine
        self._paths = paths
        self.broken: Dict[str, str] = {}
        self.remarks: List[str] = []
        self._base = BaseSettings(options.colors, sets[FIT].colors)
        self._histograms = Histograms({}, {})
        self._recorded = list(self._divided(paths))

    def run(self, report: Report) -> str:
        """Fit the colors and write the report; return a summary."""
        with self._outcomes(fit_pieces.count, (), '.count') as counted:
            try:
                fits = self._fits(counted)
            except UserError as error:      # its cause is not how the pieces ran: none is kept
                failure = error
            else:
                candidates = [self._base.candidate({
                    color: found[min(number, len(found) - 1)].box
                    for color, found in fits.items()})
                    for number in range(max(map(len, fits.values())))]
                # the last one is compared with the result; a new color has none yet
                candidates.append(self._base.candidate({
                    color: found[0].box for color, found in fits.items()
                    if self._base.before(color) is None}))
                sizes = tuple(sorted({*BLOB_SIZES, self._base.min_blob_size}))
                with self._outcomes(fit_pieces.measure, (candidates, sizes),
                                    '.measure') as measured:
                    try:
                        return report.write(self._base, fits, sizes, self._recorded,
                                            self._good(measured), self._histograms, self.broken,
                                            self.remarks)
                    except Refused as error:
                        failure = error
        raise failure

    def _divided(self, paths: Sequence[str]) -> Iterator[Recorded]:
        for path in paths:
            try:
                divided = parts.divide(path, self._options.topic,
                                       max_pixels=self._options.max_image_pixels)
                first = parts.first(path, divided, self._options.max_image_pixels)
            except UserError as error:
                self._note_broken(path, one_line(error))
                continue
            of_recording = tuple(each.of(path) for each in self._sets)
            for number, part in enumerate(divided, 1):
                source = Source(part, first.stamp_ns, tuple(self._sets), of_recording,
                                self._options.max_image_pixels)
                key = path if len(divided) == 1 else '{}, part {} of {}'.format(
                    path, number, len(divided))
                yield Recorded(key, path, source)

    def _outcomes(self, function: Any, arguments: Tuple[Any, ...], suffix: str) -> Any:
        # workers of a cluster are in other folders
        pieces = [Piece(each.key, (each.source, *arguments), (os.path.abspath(each.path),),
                        each.source.part.frames or 1) for each in self._recorded]
        return self._engine.outcomes(function, pieces, self._options.output + suffix, ' frames')

    def _note_broken(self, path: str, problem: str) -> None:
        if path not in self.broken:
            self.broken[path] = problem if path in problem else '{}: {}'.format(path, problem)

    def _fits(self, counted: Iterable[Outcome]) -> Dict[str, List[Fit]]:
        self._histograms = self._summed(counted)
        return {color: self._fits_of(color) for color in self._sets[FIT].colors}

    def _fits_of(self, color: str) -> List[Fit]:
        """Return the bounds of a color to choose from; raise UserError if there are none."""
        if not is_by_times(self._histograms, color):
            return bounds.fits(color, of_color(self._histograms, color), self._options.objective)
        found: List[Fit] = []
        for uses_brightness in (True, False):
            try:
                found += bounds.fits(color, of_color(self._histograms, color, uses_brightness),
                                     self._options.objective, by_times=True)
            except UserError as error:
                problem = error
        if not found:
            raise problem
        return found

    def _summed(self, counted: Iterable[Outcome]) -> Histograms:
        """Return the histograms of all recordings that can be read to their end."""
        for each, outcome in zip(self._recorded, counted):
            if outcome.problem:
                self._note_broken(each.path, outcome.problem)
            elif outcome.value.error:
                raise SampleError('{}: {}'.format(each.path, outcome.value.error))
        used: List[Set[str]] = [set() for _ in self._sets]
        total = Counter()
        seen: Dict[str, Remarks] = {}
        for each, outcome in zip(self._recorded, counted):
            if each.path not in self.broken:
                seen[each.path] = seen.get(each.path, Remarks()).plus(outcome.value.remarks)
                total.add_result(outcome.value.histograms)
                for number, entries in enumerate(outcome.value.used):
                    used[number].update(entries)
        self.remarks = ['{}: {}'.format(path, line) for path, remarks in seen.items()
                        for line in remarks.lines(path)]
        for line in self.remarks:
            _log.warning('%s', line)
        for samples_of, entries in zip(self._sets, used):
            self._check_used(samples_of, entries)
        return total.result()

    def _check_used(self, samples_of: Samples, used: Iterable[str]) -> None:
        for name, sample in samples_of.entries:
            is_lost = any(samples.is_named(path, name) for path in self.broken)
            if sample.entry not in used and not is_lost:
                raise SampleError('{}: {}: {} has no frame {}'.format(
                    samples_of.path, sample.entry, name or self._paths[0],
                    sample.frame if isinstance(sample, samples.Region)
                    else 'from {:g} s to {:g} s'.format(sample.start_s, sample.end_s)),
                    'frames are counted from 0, and times from the first one')

    def _good(self, outcomes: Iterable[Outcome]) -> Iterable[Tuple[int, Any]]:
        """Return the values of the recordings that can be read, with the numbers of the parts."""
        return _Good(self._recorded, outcomes, self.broken)


class _Good:
    """Outcomes without those of broken recordings; can be read several times."""

    def __init__(self, recorded: Sequence[Recorded], outcomes: Iterable[Outcome],
                 broken: Dict[str, str]):
        self._recorded, self._outcomes, self._broken = recorded, outcomes, broken

    def __iter__(self) -> Iterator[Tuple[int, Any]]:
        for number, (each, outcome) in enumerate(zip(self._recorded, self._outcomes)):
            if each.path not in self._broken and not outcome.problem:
                yield number, outcome.value
