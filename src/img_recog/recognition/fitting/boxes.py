"""Search of the box of HSV that separates the pixels of a color from all others best."""
import functools
from typing import List, NamedTuple, Tuple

import numpy as np

from img_recog.recognition.fitting.volume import Sparse, SummedVolume, sparse

_COARSE = 30, 16, 16      # bins in which all boxes are searched
# of branch and bound: sets of boxes that are halved at a time, and after which it ends
_BATCH, _MAX_SETS = 4096, 200000
_MAX_TURNS = 50         # of the descent; usually it ends after 4
_ORDERS = (0, 1, 2), (1, 2, 0), (2, 0, 1)


Margin = Tuple[int, int, int]       # levels of hue, saturation, value


class Found(NamedTuple):
    """The best box: its edges (see SummedVolume.count) and score."""

    edges: np.ndarray
    score: float


class Objective:
    """The score of boxes: the F-measure of their pixels, from 0 to 1.

    F = (1 + b^2) TP / (b^2 P + TP + FP): TP pixels of the color and FP others are in the box, P
    pixels of the color are anywhere. With b = 1 it is the harmonic mean of precision and recall; a
    larger one gives more weight to recall (van Rijsbergen, "Information Retrieval", 1979).

    margin: as if all pixels of the color were counted in a box whose sides are so many levels
    further inside, and all others in one with sides as far outside. Such a box is right even if
    all pixels move so far. Sides of saturation and value stay at 0 and 255.
    """

    def __init__(self, positive: SummedVolume, negative: SummedVolume, beta: float,
                 margin: Margin):
        self.positive, self.negative = positive, negative
        self._beta, self._margin = beta * beta, margin

    def ranks(self) -> List[np.ndarray]:
        """Return a number for each edge of saturations, and of values: between two edges with the
        same one, there are no pixels that count.
        """
        if any(self._margin):
            return [np.arange(size + 1) for size in self.positive.shape[1:]]
        return [np.concatenate([[0], np.cumsum(one | other)])
                for one, other in zip(self.positive.filled[1:], self.negative.filled[1:])]

    def score(self, edges: np.ndarray) -> np.ndarray:
        """Return the score of boxes: float of shape (...); edges: as in SummedVolume.count."""
        return self.bound(edges, edges)

    def bound(self, inner: np.ndarray, outer: np.ndarray) -> np.ndarray:
        """Return a score that no box between `inner` and `outer` exceeds; both like `edges`."""
        if any(self._margin):
            inner, outer = self._moved(inner, 1), self._moved(outer, -1)
        return self._measure(self.positive.count(outer), self.negative.count(inner))

    def scores_along(self, axis: int, edges: np.ndarray, ranges: np.ndarray) -> np.ndarray:
        """Return the scores of boxes that differ in one axis: float of shape (n,).

        edges: of one of them, of shape (6,); ranges: their sides on the axis, of shape (2, n).
        """
        inner = outer = edges
        narrow = wide = ranges
        if any(self._margin):
            inner, outer = self._moved(edges, 1), self._moved(edges, -1)
            narrow, wide = (self._moved_range(axis, ranges, sign) for sign in (1, -1))
        return self._measure(self.positive.count_along(axis, outer, wide),
                             self.negative.count_along(axis, inner, narrow))

    def _measure(self, inside: np.ndarray, wrong: np.ndarray) -> np.ndarray:
        return (1 + self._beta) * inside / np.maximum(
            self._beta * self.positive.total + inside + wrong, 1)

    def _moved(self, edges: np.ndarray, sign: int) -> np.ndarray:
        """Return boxes with their sides outwards by the margin; sign: -1 for inwards."""
        sides = np.moveaxis(edges, -1, 0)
        return np.moveaxis(np.concatenate([
            self._moved_range(axis, sides[2 * axis:2 * axis + 2], sign) for axis in range(3)]),
            0, -1)

    def _moved_range(self, axis: int, ranges: np.ndarray, sign: int) -> np.ndarray:
        (low, end), size, margin = ranges, self.positive.shape[axis], sign * self._margin[axis]
        if axis:
            low = np.where(low <= 0, 0, np.maximum(low - margin, 0))
            end = np.where(end >= size, size, np.minimum(end + margin, size))
            return np.array([low, end])
        is_all = end - low >= size
        moved = np.where(is_all, low, (low - margin) % size)
        length = np.where(is_all, size, np.clip(end - low + 2 * margin, 0, size))
        return np.array([moved, moved + length])


class BoxSearch:
    """Finds the best boxes of the same histograms by different objectives."""

    def __init__(self, positive: Sparse, negative: Sparse, shape: Tuple[int, ...]):
        """Sum up the pixels of the color and all others."""
        self._steps = [max(1, size // bins) for size, bins in zip(shape, _COARSE)]
        self._fine = SummedVolume(positive, shape), SummedVolume(negative, shape)
        self._coarse = tuple(_binned(volume, self._steps) for volume in self._fine)

    def objective(self, beta: float, margin: Margin = (0, 0, 0)) -> Objective:
        """Return an objective of all boxes."""
        return Objective(*self._fine, beta, margin)

    def best(self, beta: float = 1.0, margin: Margin = (0, 0, 0)) -> Found:
        """Return the box with the highest score; beta, margin: as in Objective.

        In coarse bins, all boxes are searched by branch and bound. From the best one, and from all
        colors, a descent chooses the best range of hue, saturation or value by turns; then the
        neighborhood of the best result is searched.
        """
        positive, negative = self._coarse
        hue, saturation, value = (size // step for size, step in zip(margin, self._steps))
        coarse = Objective(positive, negative, beta, (hue, saturation, value))
        start = _best_descent(coarse, [_whole(coarse)])
        rough = _search(coarse, *_limits(coarse), start)
        objective, scale = self.objective(beta, margin), np.repeat(self._steps, 2)
        best = _best_descent(objective, [rough.edges * scale, _whole(objective)])
        sides, (lowest, highest) = best.edges.copy(), _limits(objective)
        sides[1] -= sides[0]
        return _search(objective, np.maximum(sides - scale, lowest),
                       np.minimum(sides + scale, highest), best)


def _whole(objective: Objective) -> np.ndarray:
    hues, saturations, values = objective.positive.shape
    return np.array([0, hues, 0, saturations, 0, values])


def _limits(objective: Objective) -> Tuple[np.ndarray, np.ndarray]:
    """Return the least and the most of: first hue, number of hues, and the other four edges."""
    hues, saturations, values = objective.positive.shape
    return np.array([0, 1, 0, 1, 0, 1]), np.array(
        [hues - 1, hues, saturations - 1, saturations, values - 1, values])


def _search(objective: Objective, lowest: np.ndarray, highest: np.ndarray, best: Found) -> Found:
    """Return the best box whose sides are within limits, or `best` if none is better.

    It is branch and bound, as Lampert, Blaschko and Hofmann use it ("Beyond Sliding Windows", CVPR
    2008): sets of boxes are halved until their bound shows that none is better.
    """
    low, high, ranks = lowest[np.newaxis], highest[np.newaxis], objective.ranks()
    bounds, examined = _bounds(objective, low, high), 0
    while len(bounds) and examined < _MAX_SETS:
        order = np.argsort(-bounds, kind='stable')      # the most promising sets first
        chosen = order[:_BATCH]
        examined += len(chosen)
        new_low, new_high = _halves(low[chosen], high[chosen], ranks)
        if len(new_low):
            middles = _middles(new_low, new_high)
            scores = objective.score(middles)
            index = int(scores.argmax())
            if scores[index] > best.score:
                best = _descent(objective, middles[index], _ORDERS[0])
        new_bounds = _bounds(objective, new_low, new_high)
        kept = order[_BATCH:int((bounds > best.score).sum())]
        new = np.flatnonzero(new_bounds > best.score)
        low, high, bounds = (np.concatenate([old.take(kept, axis=0), each.take(new, axis=0)])
                             for old, each in ((low, new_low), (high, new_high),
                                               (bounds, new_bounds)))
    return best


def _binned(volume: SummedVolume, steps: List[int]) -> SummedVolume:
    """Return the volume in which so many hues, saturations and values are one bin."""
    bins = tuple(size // step for size, step in zip(volume.shape, steps))
    lows = np.indices(bins).reshape(3, -1).T * steps
    return SummedVolume(
        sparse(volume.count(np.stack([lows, lows + steps], axis=2).reshape(-1, 6))), bins)


def _best_descent(objective: Objective, starts: List[np.ndarray]) -> Found:
    return max((_descent(objective, start, order) for start in starts for order in _ORDERS),
               key=lambda found: found.score)


def _descent(objective: Objective, edges: np.ndarray, order: Tuple[int, ...]) -> Found:
    """Return a box that no other range of one axis alone makes better."""
    score = float(objective.score(edges))
    for _ in range(_MAX_TURNS):
        before = score
        for axis in order:
            ranges = _ranges(objective.positive.shape[axis], axis == 0)
            scores = objective.scores_along(axis, edges, ranges)
            index = int(scores.argmax())
            if scores[index] > score:
                edges, score = edges.copy(), float(scores[index])
                edges[2 * axis:2 * axis + 2] = ranges[:, index]
        if score == before:
            break
    return Found(edges, score)


@functools.lru_cache(maxsize=None)
def _ranges(size: int, is_hue: bool) -> np.ndarray:
    """Return all ranges of an axis, of shape (2, n)."""
    low, end = np.mgrid[:size, 1:size + 1].reshape(2, -1)
    return np.stack([low, low + end] if is_hue else [low[low < end], end[low < end]])


def _bounds(objective: Objective, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the bound of each set of boxes."""
    outer, inner = np.empty_like(low), np.empty_like(low)
    outer[:, 0], inner[:, 0] = low[:, 0], high[:, 0]
    outer[:, 1] = np.minimum(high[:, 0] + high[:, 1], low[:, 0] + objective.positive.shape[0])
    inner[:, 1] = low[:, 0] + low[:, 1]
    outer[:, 2::2], outer[:, 3::2] = low[:, 2::2], high[:, 3::2]
    inner[:, 2::2], inner[:, 3::2] = high[:, 2::2], low[:, 3::2]
    bounds = objective.bound(inner, outer)
    # sets without a box: all of them would end before they begin
    bounds[(outer[:, 3::2] <= outer[:, 2::2]).any(axis=1)] = -1
    return bounds


def _middles(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return a box in the middle of each set."""
    middles = (low + high) // 2
    middles[:, 1] += middles[:, 0]
    return middles


def _halves(low: np.ndarray, high: np.ndarray, ranks: List[np.ndarray]
            ) -> Tuple[np.ndarray, np.ndarray]:
    """Return the halves of each set of boxes, cut where its limits are the farthest apart.

    ranks: as of Objective.
    """
    distance = high - low
    for side, each in zip(range(2, 6), (ranks[0], ranks[0], ranks[1], ranks[1])):
        distance[:, side] = each.take(high[:, side]) - each.take(low[:, side])
    rows = np.arange(len(low))
    axis = distance.argmax(axis=1)
    cut = (low[rows, axis] + high[rows, axis]) // 2
    is_one = distance[rows, axis] == 0      # one box, or equal ones: their bound is their score
    first_high, second_low = high.copy(), low.copy()
    first_high[rows, axis] = cut
    second_low[rows, axis] = cut + 1
    keep = ~is_one
    return (np.concatenate([low[keep], second_low[keep]]),
            np.concatenate([first_high[keep], high[keep]]))
