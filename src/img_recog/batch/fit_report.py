"""What fit_colors.py writes: the parameters, a report with pictures, and a table of the frames."""
import os
from typing import IO, Any, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import cv2

from img_recog import files
from img_recog.batch.engine import Results
from img_recog.batch.fit_pieces import CHECK, FIT
from img_recog.batch.fit_result import ColorLimit, Statistics, Worst
from img_recog.batch.fit_settings import BaseSettings, as_yaml, settings_of
from img_recog.batch.work import Piece
from img_recog.command_line import results
from img_recog.errors import UserError, counted
from img_recog.recognition import excluded, overlay
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.fitting import picture
from img_recog.recognition.fitting.bounds import TIMES_ADVICE, Fit, described
from img_recog.recognition.fitting.histograms import Histograms, is_by_times, of_color
from img_recog.recognition.fitting.limits import Limit
from img_recog.recognition.fitting.samples import Samples
from img_recog.recognition.fitting.score import Score
from img_recog.recognition.fitting.volume import Box
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings import parts as reader

_EXTENSIONS = '.yaml', '.md', '.png', '.csv'
_SAMPLES = 'fit', 'check'
_WORST_F1 = 0.9         # of frames, if only times are known; below, bounds are of no use
_HEAD = ('color', 'bounds', '', 'pixels: precision', 'recall', 'frames: precision', 'recall')
_WEIGHTED = ('Wrong pixels of frames without a color are weighted as if there were not more of '
             'these frames than of those with it.')


class Line(NamedTuple):
    """A line of the table of scores: of a color, by its old or new bounds, and some samples."""

    color: str
    bounds: str
    chosen: int
    pixels: Score
    frames: Score

    def cells(self) -> List[str]:
        """Return it as texts."""
        return [self.color, self.bounds, _SAMPLES[self.chosen], *self.pixels.shares,
                *self.frames.shares]


class Chosen(NamedTuple):
    """What was chosen.

    choices: of each color; fits: by the names of the colors; size_index: of the smallest blob;
    values: the parameters; lines: how good they are; frames: how many were measured.
    """

    choices: Sequence[ColorLimit]
    fits: Dict[str, Fit]
    size_index: int
    values: Dict[str, Any]
    lines: Sequence[Line]
    frames: int


class Report:
    """The files of a run; paths: of those that are always written."""

    def __init__(self, prefix: str, sets: Sequence[Samples], objective: str):
        self._prefix, self._sets = prefix, sets
        self._objective, self._colors = objective, sets[FIT].colors
        self.paths = [prefix + extension for extension in _EXTENSIONS]

    def choose(self, base: BaseSettings, fits: Mapping[str, List[Fit]], sizes: Sequence[int],
               measured: Results, histograms: Histograms) -> Chosen:
        """Choose among the fits: of each color, as many.

        Raises UserError if only times are known of a color, and the best bounds do not recognize
        it in them.
        """
        candidates = len(fits[self._colors[0]])
        statistics = Statistics(len(self._colors), candidates + 1, sizes)
        for _, each in measured:
            statistics.add(each)
        by_times = [is_by_times(histograms, color) for color in self._colors]
        size, choices = statistics.choose(candidates, by_times)
        chosen = {color: fits[color][choice.candidate]
                  for color, choice in zip(self._colors, choices)}
        limits = {color: choice.limit.area_px for color, choice in zip(self._colors, choices)}
        for color, choice, is_timed in zip(self._colors, choices, by_times):
            if is_timed:
                _check_frames(color, chosen[color], choice.limit)
        values = base.fitted({color: fit.box for color, fit in chosen.items()}, limits, size)
        return Chosen(choices, chosen, sizes.index(size), values,
                      self._lines(base, statistics, choices, size, candidates), statistics.frames)

    def write(self, chosen: Chosen, measured: Results, histograms: Histograms,
              unused: Sequence[str]) -> str:
        """Write the files, and return a summary; unused: lines of the report."""
        settings, results_of = settings_of(chosen.values), list(filter(_is_result, chosen.lines))
        with files.atomic_write(self.paths) as (parameters, report, histogram, table):
            parameters.write(as_yaml(chosen.values, self._comment(results_of)).encode())
            worst, pieces = self._write_table(table, measured, chosen)
            pictures = self._write_worst(worst, pieces, settings)
            profiles = [picture.profile(color, of_color(histograms, color.name))
                        for color in settings.colors if color.name in chosen.fits]
            with results.picture(histogram, picture.size_in(profiles)) as figure:
                picture.draw(figure, profiles)
            report.write(self._text(
                chosen, settings, len({piece.key for piece in pieces}), pictures, unused).encode())
        return '\n'.join([*('{}: {}; {}'.format(
            line.color, described(chosen.fits[line.color].box), _percent(line))
            for line in results_of), ', '.join(self.paths)])

    def _lines(self, base: BaseSettings, statistics: Statistics, choices: Sequence[ColorLimit],
               size: int, before: int) -> List[Line]:
        lines = []
        for number, (color, choice) in enumerate(zip(self._colors, choices)):
            ways = [('fitted', choice.candidate, size, choice.limit.area_px)]
            known = base.before(color)
            if known is not None:
                ways.append(('before', before, base.min_blob_size, known.area_limit_px))
            for chosen in (FIT, CHECK)[:len(self._sets)]:
                for name, candidate, blob_size, limit_px in ways:
                    lines.append(Line(
                        color, name, chosen,
                        statistics.pixels(chosen, candidate, number, blob_size),
                        statistics.score(chosen, candidate, number, blob_size, limit_px)))
        return lines

    def _comment(self, lines: Sequence[Line]) -> List[str]:
        return ['Fitted by fit_colors.py to {}, objective {}.'.format(
            os.path.basename(self._sets[FIT].path), self._objective),
            *('{}: {}'.format(line.color, _percent(line)) for line in lines)]

    def _write_table(self, file: IO[bytes], measured: Results, chosen: Chosen
                     ) -> Tuple[Worst, List[Piece]]:
        """Write the table; return the worst frames in it, and the pieces that they are in."""
        worst, size = Worst(chosen.choices, chosen.size_index), chosen.size_index
        pieces: List[Piece] = []
        with results.csv_table(file, ['recording', 'frame', 'time_s', 'samples', *(
                color + suffix for color in self._colors for suffix in (
                    '_px', '_seen', '_in_view', '_inside_px', '_wrong_px', '_missed_px'))]
                               ) as table:
            for piece, each in measured:
                for row, used in enumerate(each.chosen.tolist()):
                    cells: List[Any] = []
                    for color, (candidate, limit) in enumerate(chosen.choices):
                        area_px = int(each.areas[row, candidate, color, size])
                        in_view = int(each.in_view[row, color])
                        cells += [area_px, int(area_px > limit.area_px)]
                        cells += [''] * 4 if used < 0 else [
                            '' if in_view < 0 else in_view,
                            *each.pixels[row, candidate, color, size].tolist()]
                    table.writerow([piece.key, int(each.frames[row]),
                                    '{:.6f}'.format(each.times_s[row]),
                                    _SAMPLES[used] if used >= 0 else '', *cells])
                worst.add(len(pieces), each)
                pieces.append(piece)
        return worst, pieces

    def _write_worst(self, worst: Worst, pieces: Sequence[Piece], settings: RecognitionSettings
                     ) -> List[Tuple[str, str]]:
        """Draw the worst frames; return the path and the description of each picture."""
        pictures = []
        for number, (color, frame) in enumerate(worst.frames(), 1):
            piece = pieces[frame.source]
            recorded, _, max_pixels, *_ = piece.arguments
            image = next(each for index, each in enumerate(reader.read(
                piece.key, recorded.part, max_pixels).read()) if index == frame.row)
            extractor = ColorExtractor(settings)
            areas_px = extractor.measure(image.image, image.encoding)
            drawn = overlay.draw(extractor, settings.colors, areas_px, [])
            path = '{}_worst_{}.png'.format(self._prefix, number)
            with files.atomic_write([path]) as (file,):
                file.write(cv2.imencode('.png', drawn)[1].tobytes())
            pictures.append((path, '\n'.join([
                '{}: frame {} of {}, {} px wrong'.format(
                    self._colors[color], image.number, os.path.basename(piece.key),
                    frame.wrong_px), '',
                *('- ' + line for line in excluded.lines(extractor, areas_px, settings))])))
        return pictures

    def _text(self, chosen: Chosen, settings: RecognitionSettings,
              recordings: int, pictures: Sequence[Tuple[str, str]], unused: Sequence[str]
              ) -> str:
        """Return the report as Markdown; recordings: how many were used."""
        lines = ['# Fitted colors', '', 'Samples: {}. Objective: {}. Recordings: {}, with {}.'
                 .format(', '.join(each.path for each in self._sets), self._objective,
                         recordings, counted(chosen.frames, 'frame')),
                 *unused, '', _WEIGHTED, '',
                 *results.markdown_table(_HEAD, [line.cells() for line in chosen.lines]), '']
        lines += ['- {}: {}; area limit {} px; the samples may move by {}'.format(
            color.name, described(Box(color.hue, color.saturation, color.value)),
            color.area_limit_px, _margin(chosen.fits[color.name]))
            for color in settings.colors if color.name in chosen.fits]
        lines += ['', 'Groups of fewer than {} pixels are ignored (min_blob_size).'.format(
            settings.min_blob_size)]
        for text, path in [('Histograms with the bounds', self.paths[2]), *(
                (text, path) for path, text in pictures)]:
            lines += ['', text, '', '![{}]({})'.format(
                text.splitlines()[0], os.path.basename(path))]
        return '\n'.join(lines) + '\n'


def _is_result(line: Line) -> bool:
    return (line.bounds, line.chosen) == ('fitted', FIT)


def _percent(line: Line) -> str:
    is_labeled_px = line.pixels.found + line.pixels.missed
    score, what = (line.pixels, 'labeled pixels') if is_labeled_px else (line.frames, 'frames')
    return 'precision {}, recall {} of the {}'.format(*score.shares, what)


def _check_frames(color: str, fit: Fit, limit: Limit) -> None:
    found, wrong, missed = limit.score
    if limit.score.f1 < _WORST_F1:
        raise UserError(
            'no bounds separate {}: the best ones, {}, with an area limit of {} px, find it in {} '
            'of {} frames in which it is in view, and in {} in which it is not'.format(
                color, described(fit.box), limit.area_px, found, found + missed, wrong),
            TIMES_ADVICE)


def _margin(fit: Fit) -> str:
    return ', '.join('{} {}'.format(name, 'any' if levels is None else levels)
                     for name, levels in zip(('hue', 'saturation', 'value'), fit.margin))
