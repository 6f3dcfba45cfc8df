"""The program fit_colors: finds the bounds of colors that separate them best in recordings."""
import argparse
import logging
import os
from typing import Any, Dict, Iterable, List, Optional, Sequence, Set

from img_recog import files
from img_recog.batch import fit_pieces, recorded
from img_recog.batch.engine import Engine, Results, add_options
from img_recog.batch.fit_pieces import FIT, BaseSettings
from img_recog.batch.fit_report import Report
from img_recog.batch.recorded import RecordingPart
from img_recog.batch.work import Piece
from img_recog.command_line import programs
from img_recog.errors import UserError
from img_recog.processes.signals import Interrupts
from img_recog.recognition.fitting import bounds, sample_file, samples
from img_recog.recognition.fitting.bounds import OBJECTIVES, PIXELS, Fit
from img_recog.recognition.fitting.histograms import Counter, Histograms, is_by_times, of_color
from img_recog.recognition.fitting.limits import BLOB_SIZES
from img_recog.recognition.fitting.samples import SampleError, Samples
from img_recog.recordings import recording_names
from img_recog.recordings.frames import Remarks

_log = logging.getLogger('fit_colors.py')


def main(arguments: Optional[Sequence[str]] = None) -> int:
    """Run the program; return its exit code."""
    return programs.run('fit_colors.py', _run, 'cannot fit the colors', arguments)


def _run(arguments: List[str], interrupts: Interrupts) -> str:
    options = _parse(arguments)
    paths = recording_names.expand(options.recordings, _log.warning)
    sets = [sample_file.read(path) for path in (options.samples, options.check) if path]
    sets[FIT].check_colors()
    for each in sets:
        each.check_recordings(paths)
    if options.check:
        _check_colors(*sets)
    prefix = files.output_prefix(options.output, 'fit_colors')
    report = Report(prefix, sets, options.objective)
    for path in [*paths, options.samples, options.check, options.colors]:
        for output in report.paths:
            files.refuse_input(output, path, 'read', 'set --output to another')
    with Engine(options, interrupts, prefix, _log) as engine:
        summary = _Fitting(options, sets, paths, engine).run(report)
    return programs.Incomplete(summary) if engine.problems else summary


def _check_colors(fit: Samples, check: Samples) -> None:
    for color in check.colors:
        if color not in fit.colors:
            raise SampleError('{}: there is no color {}; those of {} are {}'.format(
                check.path, color, fit.path, ', '.join(fit.colors)))


class _Fitting:
    """A run of the program."""

    def __init__(self, options: argparse.Namespace, sets: Sequence[Samples],
                 paths: Sequence[str], engine: Engine):
        self._options, self._sets, self._paths, self._engine = options, sets, paths, engine
        self._said: List[str] = []      # of what could not be used
        self._base = BaseSettings(options.colors, sets[FIT].colors)

    def run(self, report: Report) -> str:
        """Fit the colors and write the report; return a summary."""
        # workers of a cluster are in other folders
        divided = recorded.divided(self._engine, {path: os.path.abspath(path)
                                                  for path in self._paths}, self._options)
        counted = self._stage(fit_pieces.count, divided)
        with self._engine.judging():
            histograms = self._summed(counted)
            fits = {color: self._fits_of(color, histograms) for color in self._sets[FIT].colors}
        count = max(map(len, fits.values()))
        fits = {color: found + found[-1:] * (count - len(found)) for color, found in fits.items()}
        candidates = [self._base.candidate({
            color: found[number].box for color, found in fits.items()}) for number in range(count)]
        # the last one is compared with the result; a new color has none yet
        candidates.append(self._base.candidate({
            color: found[0].box for color, found in fits.items()
            if self._base.before(color) is None}))
        sizes = tuple(sorted({*BLOB_SIZES, self._base.min_blob_size}))
        divided = [each for each in divided if each.name not in self._engine.problems]
        measured = self._stage(fit_pieces.measure, divided, candidates, sizes)
        with self._engine.judging():
            chosen = report.choose(self._base, fits, sizes, measured, histograms)
        return report.write(chosen, measured, histograms,
                            recorded.not_used(self._engine.problems, self._said))

    def _stage(self, function: Any, parts: Sequence[RecordingPart], *arguments: Any) -> Results:
        common = tuple(self._sets), self._options.max_image_pixels
        return self._engine.run(function, [
            Piece(each.name, (each, *common, *arguments), (each.path,), each.part.frames or 1)
            for each in parts], ' frames')

    def _fits_of(self, color: str, histograms: Histograms) -> List[Fit]:
        """Return the bounds of a color to choose from; raise UserError if there are none."""
        if not is_by_times(histograms, color):
            return bounds.fits(color, of_color(histograms, color), self._options.objective)
        found: List[Fit] = []
        for uses_brightness in (True, False):
            try:
                found += bounds.fits(color, of_color(histograms, color, uses_brightness),
                                     self._options.objective, by_times=True)
            except UserError as error:
                problem = error
        if not found:
            raise problem
        return found

    def _summed(self, counted: Results) -> Histograms:
        """Return the histograms of all recordings that can be read to their end."""
        used: List[Set[str]] = [set() for _ in self._sets]
        total = Counter()
        seen: Dict[str, List[Remarks]] = {}
        for piece, found in counted:
            if found.error:
                raise SampleError('{}: {}'.format(piece.key, found.error))
            seen.setdefault(piece.key, []).append(found.remarks)
            total.add_result(found.histograms)
            for entries, more in zip(used, found.used):
                entries.update(more)
        if not seen:
            raise UserError('none of the recordings can be used', 'the lines above say why')
        self._said = recorded.said(seen, _log)
        for samples_of, entries in zip(self._sets, used):
            self._check_used(samples_of, entries)
        return total.result()

    def _check_used(self, samples_of: Samples, used: Iterable[str]) -> None:
        for name, sample in samples_of.entries:
            is_lost = any(samples.is_named(path, name) for path in self._engine.problems)
            if sample.entry not in used and not is_lost:
                raise SampleError('{}: {}: {} has no frame {}'.format(
                    samples_of.path, sample.entry, name or self._paths[0],
                    sample.frame if isinstance(sample, samples.Region)
                    else 'from {:g} s to {:g} s'.format(sample.start_s, sample.end_s)),
                    'frames are counted from 0, and times from the first one')


def _parse(arguments: Sequence[str]) -> argparse.Namespace:
    """Return the options; paths without a ~."""
    parser = programs.parser(
        'fit_colors.py', 'Find the bounds of colors that separate them best in '
        'recordings. Writes a parameter file of color_extract, a report with pictures, and a '
        'table with a row for each frame.')
    recording_names.add_to(parser)
    parser.add_argument('--samples', metavar='YAML', required=True,
                        help='where in the recordings the colors are')
    parser.add_argument('--check', metavar='YAML', default='',
                        help='samples of other frames, by which the result is only measured')
    parser.add_argument('--colors', metavar='YAML', default='',
                        help='parameter file of color_extract: the result keeps all of it but '
                        'what is fitted, and the report compares both (default: the article\'s '
                        'colors)')
    parser.add_argument('--objective', choices=OBJECTIVES, default=PIXELS,
                        help='what is best: most pixels right; most frames right; or the widest '
                        'margin for other light (default: %(default)s)')
    recording_names.add_output(parser, 'fit_colors.yaml, .md, .png and .csv')
    add_options(parser)
    options = parser.parse_args(arguments)
    for name in ('samples', 'check', 'colors', 'output'):
        setattr(options, name, os.path.expanduser(getattr(options, name)))
    return options
