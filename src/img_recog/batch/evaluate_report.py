"""The report of an evaluation: its table, its summary in Markdown, and its picture."""
import math
from typing import IO, Any, Dict, Iterator, List, Sequence, Tuple

import numpy as np
from matplotlib.figure import Figure

from img_recog.batch.evaluation import ColorSet, Evaluated, Truth, score
from img_recog.command_line import results
from img_recog.errors import counted
from img_recog.recognition.commands import Command
from img_recog.recognition.fitting.score import Score

_DPI, _WIDTH_IN, _ROW_IN = 100, 12.0, 2.5
_MAX_ROWS = 12              # recordings in the picture
_MAX_SPANS = 10             # of frames in which sets of colors differ, in the report


def table(sets: Sequence[ColorSet], found: Sequence[Evaluated]) -> results.Table:
    """Return the table: a row for each frame and set of colors."""
    areas = list(dict.fromkeys(color.name + '_px' for each in sets
                               for color in each.settings.colors))
    columns = ['recording', 'colors', 'frame', 'time_s', *areas, 'linear_x_m_per_s',
               'angular_z_rad_per_s']

    def rows() -> Iterator[Dict[str, Any]]:
        for each in found:
            for colors, commands, areas_px in zip(sets, each.commands, each.measured.areas_px):
                names = [color.name + '_px' for color in colors.settings.colors]
                for index, frame in enumerate(each.measured.numbers):
                    row = {'recording': each.name, 'colors': colors.name, 'frame': frame,
                           'time_s': each.times_s[index],
                           **dict(zip(names, areas_px[index].tolist()))}
                    command = _holding(commands[index])
                    if command is not None:
                        row['linear_x_m_per_s'] = command.linear_x
                        row['angular_z_rad_per_s'] = command.angular_z
                    yield row
    return results.Table(columns, rows())


def _holding(commands: Sequence[Command]) -> Any:
    """Return the last command of a frame, which holds; None for none."""
    return commands[-1] if commands else None


def markdown(sets: Sequence[ColorSet], found: Sequence[Evaluated], truth: Truth,
             unused: Sequence[str]) -> str:
    """Return the report; unused: lines on what could not be used."""
    lines = ['# Recordings under {}'.format(counted(len(sets), 'set of colors'))]
    lines += results.markdown_part(
        'How many frames are above the limit of a color, and have a command:',
        ['recording', 'colors', 'frames', 'above the limit', 'with a command'],
        [[each.name, colors.name, str(len(each.measured.numbers)),
          ', '.join('{} {:.1f} %'.format(color.name, 100 * share) for color, share in zip(
              colors.settings.colors, _shares(each, number, colors))),
          '{:.1f} %'.format(100 * sum(map(bool, commands)) / len(commands))]
         for each in found
         for number, (colors, commands) in enumerate(zip(sets, each.commands))])
    if truth:
        lines += results.markdown_part(
            'Found in the frames of the truth:',
            ['colors', 'color', 'precision', 'recall', 'frames'], _scores(sets, found, truth))
    spans = sorted(_spans(sets, found), key=lambda span: (-span[3], span[:3]))
    lines += results.markdown_part(
        'Where other colors than {} command something else, the longest first:'.format(
            sets[0].name),
        ['recording', 'colors', 'from', 'frames'],
        [[name, colors, '{:.2f} s'.format(begin_s), str(count)]
         for name, colors, begin_s, count in spans[:_MAX_SPANS]])
    if found and len(sets) > 1 and not spans:
        lines += ['', 'All sets of colors command the same in all frames.']
    return '\n'.join([*lines, *unused]) + '\n'


def _shares(each: Evaluated, number: int, colors: ColorSet) -> List[float]:
    limits_px = [color.area_limit_px for color in colors.settings.colors]
    return np.mean(each.measured.areas_px[number] > limits_px, axis=0).tolist()


def _scores(sets: Sequence[ColorSet], found: Sequence[Evaluated], truth: Truth
            ) -> Iterator[List[str]]:
    for number, colors in enumerate(sets):
        for index, color in enumerate(colors.settings.colors):
            total = Score(*np.sum([score(each, number, index, colors.settings, truth)
                                   for each in found] or [Score(0, 0, 0)], axis=0).tolist())
            counted = sum((frame, color.name) in truth.get(each.name, {}) for each in found
                          for frame in each.measured.numbers)
            yield [colors.name, color.name, *total.shares, str(counted)]


def _spans(sets: Sequence[ColorSet], found: Sequence[Evaluated]
           ) -> Iterator[Tuple[str, str, float, int]]:
    """Yield where commands differ from those of the first set: from when, in s; frames."""
    for each in found:
        first = list(map(_holding, each.commands[0]))
        for colors, commands in zip(sets[1:], each.commands[1:]):
            differs = [mine != other for mine, other in zip(map(_holding, commands), first)]
            edges = np.flatnonzero(np.diff([False, *differs, False]))
            for begin, end in zip(edges[::2].tolist(), edges[1::2].tolist()):
                yield each.name, colors.name, each.times_s[begin], end - begin


def draw(file: IO[bytes], sets: Sequence[ColorSet], found: Sequence[Evaluated]) -> None:
    """Write the picture, a PNG: the command of each set over time."""
    shown = list(found[:_MAX_ROWS])
    with results.style(9.0):
        figure = Figure(figsize=(_WIDTH_IN, _ROW_IN * max(1, len(shown)) + 0.5), dpi=_DPI)
        rows = figure.subplots(max(1, len(shown)), 1, squeeze=False)[:, 0]
        for axes, each in zip(rows, shown):
            for colors, commands in zip(sets, each.commands):
                axes.step(each.times_s, [math.nan if command is None else command.linear_x
                                         for command in map(_holding, commands)],
                          where='post', label=colors.name)
            axes.set_title(each.name)
            axes.set_ylabel('linear.x (m/s)')
        rows[-1].set_xlabel('time (s)')
        if shown:
            rows[0].legend()
        figure.tight_layout()
        results.write_picture(file, figure)
