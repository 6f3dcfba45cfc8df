"""What fit_colors.py writes: the parameters, a report with pictures, and a table of the frames."""
import csv
import io
import os
from typing import Any, Iterable, List, Mapping, NamedTuple, Sequence, Tuple

from img_recog import files
from img_recog.batch.fit_pieces import CHECK, FIT, Measured
from img_recog.batch.fit_result import Choice, Statistics, Worst, rows
from img_recog.batch.fit_settings import BaseSettings, as_yaml, settings_of
from img_recog.errors import UserError
from img_recog.recognition import tuning_picture
from img_recog.recognition.areas import bgr_copy
from img_recog.recognition.fitting import picture
from img_recog.recognition.fitting.bounds import TIMES_ADVICE, Fit, described
from img_recog.recognition.fitting.histograms import Histograms, is_by_times, of_color
from img_recog.recognition.fitting.limits import Limit
from img_recog.recognition.fitting.samples import Samples
from img_recog.recognition.fitting.score import Score
from img_recog.recognition.fitting.volume import Box
from img_recog.recognition.settings import RecognitionSettings
from img_recog.recordings import parts as reader

_EXTENSIONS = '.yaml', '.md', '.png', '.csv'
_SAMPLES = 'fit', 'check'
_WORST_F1 = 0.9         # of frames, if only times are known; below, bounds are of no use
_HEAD = ('| color | bounds | | pixels: precision | recall | frames: precision | recall |\n'
         '|---|---|---|---|---|---|---|\n')
_WEIGHTED = ('Wrong pixels of frames without a color are weighted as if there were not more of '
             'these frames than of those with it.\n')


class Refused(UserError):
    """Of a color only times are known, and the best bounds do not recognize it in them."""


class Line(NamedTuple):
    """A line of the table of scores: of a color, by its old or new bounds, and some samples."""

    color: str
    bounds: str
    chosen: int
    pixels: Score
    frames: Score

    def text(self) -> str:
        """Return it as Markdown."""
        return '| {} |\n'.format(' | '.join([self.color, self.bounds, _SAMPLES[self.chosen],
                                             *self.pixels.shares, *self.frames.shares]))


class Report:
    """The files of a run; paths: of those that are always written."""

    def __init__(self, prefix: str, sets: Sequence[Samples], recorded: Sequence[str],
                 objective: str):
        self._prefix, self._sets, self._recordings = prefix, sets, recorded
        self._objective, self._colors = objective, sets[FIT].colors
        self.paths = [prefix + extension for extension in _EXTENSIONS]

    def write(self, base: BaseSettings, fits: Mapping[str, List[Fit]], sizes: Sequence[int],
              parts: Sequence[Any], measured: Iterable[Tuple[int, Measured]],
              histograms: Histograms, broken: Mapping[str, str], remarks: Sequence[str]) -> str:
        """Choose among the fits, write the files, and return a summary.

        Raises Refused before it writes.
        parts: what was measured, with path and source; measured: by the number of the part, can be
        read several times.
        """
        candidates = max(map(len, fits.values()))
        statistics = Statistics(len(self._colors), candidates + 1, sizes)
        for _, each in measured:
            statistics.add(each)
        by_times = [is_by_times(histograms, color) for color in self._colors]
        size, choices = statistics.choose(candidates, by_times)
        chosen = {color: fits[color][min(choice.candidate, len(fits[color]) - 1)]
                  for color, choice in zip(self._colors, choices)}
        limits = {color: choice.limit.area_px for color, choice in zip(self._colors, choices)}
        for color, choice in zip(self._colors, choices):
            if is_by_times(histograms, color):
                _check_frames(color, chosen[color], choice.limit)
        values = base.fitted({color: fit.box for color, fit in chosen.items()}, limits, size)
        settings = settings_of(values)
        lines = self._lines(base, statistics, choices, size, candidates)
        with files.atomic_write(self.paths) as (parameters, report, histogram, table):
            parameters.write(as_yaml(values, self._comment(lines)).encode())
            worst = self._write_table(table, measured, parts, choices, sizes.index(size))
            pictures = self._write_worst(worst, parts, settings)
            figure = picture.draw([picture.profile(color, of_color(histograms, color.name))
                                   for color in settings.colors if color.name in chosen])
            figure.savefig(histogram, format='png')
            report.write(self._text(chosen, settings, lines, pictures, broken,
                                    remarks, statistics.frames).encode())
        return '\n'.join([*('{}: {}; {}'.format(
            line.color, described(chosen[line.color].box), _percent(line)) for line in lines
            if _is_result(line)), ', '.join(self.paths)])

    def _lines(self, base: BaseSettings, statistics: Statistics, choices: Sequence[Choice],
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
            *('{}: {}'.format(line.color, _percent(line)) for line in lines if _is_result(line))]

    def _write_table(self, file: io.BufferedRandom, measured: Iterable[Tuple[int, Measured]],
                     parts: Sequence[Any], choices: Sequence[Choice], size_index: int) -> Worst:
        """Write the table, and return the worst frames in it."""
        worst = Worst(len(self._colors))
        text = io.TextIOWrapper(file, 'utf-8', newline='', write_through=True)
        table = csv.writer(text, lineterminator='\n')
        table.writerow(['recording', 'frame', 'time_s', 'samples', *(
            color + suffix for color in self._colors for suffix in (
                '_px', '_seen', '_in_view', '_inside_px', '_wrong_px', '_missed_px'))])
        for number, each in measured:
            for index, row in enumerate(rows(each, choices, size_index)):
                used = int(each.chosen[index])
                cells = []
                for color, (part, choice) in enumerate(zip(row, choices)):
                    cells += [part.area_px, int(part.area_px > choice.limit.area_px),
                              *(('', '', '', '') if used < 0 else (
                                  '' if part.in_view < 0 else part.in_view, *part.score))]
                    if used >= 0:
                        worst.add(color, part, choice.limit, number, index)
                table.writerow([parts[number].path, int(each.frames[index]),
                                '{:.6f}'.format(each.times_s[index]),
                                _SAMPLES[used] if used >= 0 else '', *cells])
        text.detach()
        return worst

    def _write_worst(self, worst: Worst, parts: Sequence[Any], settings: RecognitionSettings
                     ) -> List[Tuple[str, str]]:
        """Draw the worst frames; return the path and the description of each picture."""
        pictures = []
        for number, (color, frame) in enumerate(worst.frames(), 1):
            part = parts[frame.source]
            image = next(each for index, each in enumerate(reader.read(
                part.path, part.source.part, part.source.max_pixels).read()) if index == frame.row)
            figure, _ = tuning_picture.draw(bgr_copy(image.image, image.encoding), settings)
            path = '{}_worst_{}.png'.format(self._prefix, number)
            with files.atomic_write([path]) as (file,):
                figure.savefig(file, format='png', dpi=tuning_picture.DPI)
            pictures.append((path, '{}: frame {} of {}, {} px wrong'.format(
                self._colors[color], image.number, os.path.basename(part.path), frame.wrong_px)))
        return pictures

    def _text(self, chosen: Mapping[str, Fit], settings: RecognitionSettings,
              lines: Sequence[Line], pictures: Sequence[Tuple[str, str]],
              broken: Mapping[str, str], remarks: Sequence[str], frames: int) -> str:
        """Return the report as Markdown."""
        parts = ['# Fitted colors\n', 'Samples: {}. Objective: {}. Recordings: {}, with {} frames.'
                 '\n'.format(', '.join(each.path for each in self._sets), self._objective,
                             len(self._recordings) - len(broken), frames)]
        if broken:
            parts.append('Not read:\n\n' + ''.join(
                '- {}\n'.format(problem) for problem in broken.values()))
        if remarks:
            parts.append('Not used:\n\n' + ''.join('- {}\n'.format(line) for line in remarks))
        parts.append(_WEIGHTED)
        parts.append(_HEAD + ''.join(line.text() for line in lines))
        for color in settings.colors:
            if color.name in chosen:
                parts.append('- {}: {}; area limit {} px; the samples may move by {}\n'.format(
                    color.name, described(Box(color.hue, color.saturation, color.value)),
                    color.area_limit_px, _margin(chosen[color.name])))
        parts.append('Groups of fewer than {} pixels are ignored (min_blob_size).\n'.format(
            settings.min_blob_size))
        parts.append('![Histograms with the bounds]({})\n'.format(
            os.path.basename(self.paths[2])))
        for path, text in pictures:
            parts.append('{}\n\n![{}]({})\n'.format(text, text, os.path.basename(path)))
        return '\n'.join(parts)


def _is_result(line: Line) -> bool:
    return (line.bounds, line.chosen) == ('fitted', FIT)


def _percent(line: Line) -> str:
    is_labeled_px = line.pixels.found + line.pixels.missed
    score, what = (line.pixels, 'labeled pixels') if is_labeled_px else (line.frames, 'frames')
    return 'precision {}, recall {} of the {}'.format(*score.shares, what)


def _check_frames(color: str, fit: Fit, limit: Limit) -> None:
    found, wrong, missed = limit.score
    if limit.score.f1 < _WORST_F1:
        raise Refused(
            'no bounds separate {}: the best ones, {}, with an area limit of {} px, find it in {} '
            'of {} frames in which it is in view, and in {} in which it is not'.format(
                color, described(fit.box), limit.area_px, found, found + missed, wrong),
            TIMES_ADVICE)


def _margin(fit: Fit) -> str:
    return ', '.join('{} {}'.format(name, 'any' if levels is None else levels)
                     for name, levels in zip(('hue', 'saturation', 'value'), fit.margin))
