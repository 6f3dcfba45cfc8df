"""What fit_colors.py writes: the parameters, a report with pictures, and a table of the frames."""
import os
from typing import IO, Any, Dict, List, Mapping, NamedTuple, Sequence, Tuple

import cv2
import numpy as np

from img_recog import files
from img_recog.batch.engine import Results
from img_recog.batch.fit_pieces import CHECK, FIT, BaseSettings, MeasuredPart, as_yaml, settings_of
from img_recog.batch.work import Piece
from img_recog.command_line import results
from img_recog.errors import UserError, counted
from img_recog.recognition import overlay
from img_recog.recognition.areas import ColorExtractor, to_hsv
from img_recog.recognition.fitting import picture
from img_recog.recognition.fitting.bounds import TIMES_ADVICE, Fit, described
from img_recog.recognition.fitting.histograms import Histograms, is_by_times, of_color
from img_recog.recognition.fitting.limits import Areas, Limit, best_size
from img_recog.recognition.fitting.samples import Samples
from img_recog.recognition.fitting.score import Score
from img_recog.recognition.fitting.volume import Box
from img_recog.recognition.recognition_settings import RecognitionSettings
from img_recog.recordings import parts as reader

_WORST = 2      # frames of each color
_WIDE_GAP = 100.0       # between areas; wider ones are not better
_EXTENSIONS = '.yaml', '.md', '.png', '.csv'
_SAMPLES = 'fit', 'check'
_WORST_F1 = 0.9         # of frames, if only times are known; below, bounds are of no use
_HEAD = ('color', 'bounds', '', 'pixels: precision', 'recall', 'frames: precision', 'recall')
_WEIGHTED = ('Wrong pixels of frames without a color are weighted as if there were not more of '
             'these frames than of those with it.')


def lines(extractor: ColorExtractor, areas_px: Sequence[int], settings: RecognitionSettings
          ) -> List[str]:
    """Return a line for each color of the last measured image.

    It has the area, its limit, and for each bound the pixels that are not counted because of it
    alone. areas_px: returned by that measurement; settings: those of the extractor.
    """
    image = extractor.bgr()
    rows, columns = settings.region((image.shape[0], image.shape[1]))
    part = image[rows, columns]
    # OpenCV rejects an image without pixels, as when the region is outside of the image
    hsv = to_hsv(part, 'bgr8') if part.size else part
    found = []
    for color, area_px in zip(settings.colors, areas_px):
        hue, saturation, value = (_within(hsv[..., channel], bounds) for channel, bounds in
                                  enumerate((color.hue, color.saturation, color.value)))
        hues = hsv[..., 0][~hue & saturation & value]
        others_px = np.count_nonzero(hue & saturation & value) - area_px
        found.append(
            '{}: {} px, {} the limit of {} px; out of bounds only by hue: {} px{}, only by '
            'saturation: {} px, only by value: {} px{}'.format(
                color.name, area_px, 'above' if area_px > color.area_limit_px else 'not above',
                color.area_limit_px, hues.size,
                ' (most at {})'.format(np.bincount(hues).argmax()) if hues.size else '',
                np.count_nonzero(hue & ~saturation & value),
                np.count_nonzero(hue & saturation & ~value),
                '; in too small groups or outside of its rows and columns: {} px'.format(
                    others_px) if others_px else ''))
    return found


def _within(plane: np.ndarray, bounds: Tuple[int, int]) -> np.ndarray:
    """Return where a plane is within bounds, both included; a low above high wraps through 0."""
    low, high = bounds
    if low > high:
        return (plane >= low) | (plane <= high)
    return (plane >= low) & (plane <= high)


class ColorLimit(NamedTuple):
    """What was chosen for a color: number of the candidate, and its area limit."""

    candidate: int
    limit: Limit


class WorstFrame(NamedTuple):
    """A frame in which many pixels are wrong; source: which part, row: of its measurements."""

    wrong_px: int
    source: int
    row: int


class Statistics:
    """The areas of each color by each candidate and blob size, of all frames with samples.

    frames: that were measured, with samples or not.
    """

    def __init__(self, colors: int, candidates: int, sizes: Sequence[int]):
        self._colors, self._candidates, self._sizes = colors, candidates, list(sizes)
        self._areas: Dict[Tuple[int, int, int, int], Areas] = {}
        self.frames = 0
        # of FIT and CHECK, of frames without and with the color: inside, wrong and missed pixels
        self._pixels = np.zeros((2, 2, candidates, colors, len(sizes), 3), np.int64)
        self._frames = np.zeros((2, 2, colors), np.int64)

    def add(self, measured: MeasuredPart) -> None:
        """Count the frames of a part."""
        self.frames += len(measured.frames)
        for chosen in (FIT, CHECK):
            for is_in_view in (0, 1):
                picked = (measured.in_view == is_in_view) & (measured.chosen == chosen)[:, None]
                self._frames[chosen, is_in_view] += picked.sum(axis=0)
                self._pixels[chosen, is_in_view] += (
                    measured.pixels * picked[:, None, :, None, None]).sum(axis=0)
        for row, chosen in enumerate(measured.chosen):
            for color in range(self._colors):
                in_view = int(measured.in_view[row, color])
                if chosen < 0 or in_view < 0:
                    continue
                for candidate in range(self._candidates):
                    for number, area in enumerate(measured.areas[row, candidate, color]):
                        self._of(int(chosen), candidate, color, number).add(int(area),
                                                                            bool(in_view))

    def choose(self, candidates: int, by_times: Sequence[bool]) -> Tuple[int, List[ColorLimit]]:
        """Return the best blob size, and the best of the first `candidates` for each color.

        by_times: for each color, whether only times are known; then gaps count, too.
        """
        choices = {size: [max((ColorLimit(each, self._of(FIT, each, color, number).limit())
                               for each in range(candidates)),
                              key=lambda choice: (choice.limit.score.f1, min(
                                  choice.limit.gap, _WIDE_GAP if is_by_times else 0)))
                          for color, is_by_times in enumerate(by_times)]
                   for number, size in enumerate(self._sizes)}
        size = best_size(
            {size: [choice.limit for choice in each] for size, each in choices.items()},
            {size: sum(self.pixels(FIT, choice.candidate, color, size).f1
                       for color, choice in enumerate(each)) for size, each in choices.items()})
        return size, choices[size]

    def pixels(self, chosen: int, candidate: int, color: int, size: int) -> Score:
        """Return the score of the pixels of FIT or CHECK, weighted as in histograms.Sampled."""
        without, with_color = self._pixels[chosen, :, candidate, color, self._sizes.index(size)]
        frames = self._frames[chosen, :, color]
        weight = min(1.0, frames[1] / max(1, frames[0]))
        return Score(int(with_color[0]), int(with_color[1] + round(weight * without[1])),
                     int(with_color[2]))

    def score(self, chosen: int, candidate: int, color: int, size: int,
              limit_px: int) -> Score:
        """Return the score of the frames of FIT or CHECK with a limit."""
        return self._of(chosen, candidate, color, self._sizes.index(size)).score(limit_px)

    def _of(self, *key: int) -> Areas:
        return self._areas.setdefault(key, Areas())         # type: ignore[arg-type]


class Worst:
    """The frames of each color with the most wrong pixels."""

    def __init__(self, choices: Sequence[ColorLimit], size_index: int):
        self._choices, self._size_index = choices, size_index
        self._frames: List[List[WorstFrame]] = [[] for _ in choices]

    def add(self, source: int, measured: MeasuredPart) -> None:
        """Look at the frames with samples of a part.

        Of one without labeled pixels, it counts by how much its area is too small.
        """
        for color, (candidate, limit) in enumerate(self._choices):
            chosen = candidate, color, self._size_index
            found, wrong, missed = measured.pixels[(slice(None), *chosen)].T
            too_small = np.maximum(0, limit.area_px + 1 - measured.areas[(slice(None), *chosen)])
            is_unlabeled = (measured.in_view[:, color] == 1) & (found + missed == 0)
            wrong_px = np.where(is_unlabeled, too_small, wrong + missed)
            wrong_px[measured.chosen < 0] = 0
            frames = self._frames[color] + [
                WorstFrame(int(wrong_px[row]), source, int(row))
                for row in np.argsort(-wrong_px, kind='stable')[:_WORST] if wrong_px[row]]
            self._frames[color] = sorted(frames, key=lambda frame: -frame.wrong_px)[:_WORST]

    def frames(self) -> List[Tuple[int, WorstFrame]]:
        """Return the frames with the numbers of their colors, the worst first, each once."""
        found: Dict[Tuple[int, int], Tuple[int, WorstFrame]] = {}
        for color, frames in enumerate(self._frames):
            for frame in frames:
                found.setdefault((frame.source, frame.row), (color, frame))
        return list(found.values())


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
                *('- ' + line for line in lines(extractor, areas_px, settings))])))
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
