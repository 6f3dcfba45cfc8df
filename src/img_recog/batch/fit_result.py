"""From the measurements of all frames to the limits of the colors, and what is worst."""
from typing import Dict, List, NamedTuple, Sequence, Tuple

import numpy as np

from img_recog.batch.fit_pieces import CHECK, FIT, MeasuredPart
from img_recog.recognition.fitting.limits import Areas, Limit, best_size
from img_recog.recognition.fitting.score import Score

_WORST = 2      # frames of each color
_WIDE_GAP = 100.0       # between areas; wider ones are not better


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
