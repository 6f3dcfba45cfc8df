"""The bounds of a color that are fitted to histograms, with their scores and margin."""
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog.errors import UserError
from img_recog.recognition.fitting.boxes import BoxSearch, Found, Objective
from img_recog.recognition.fitting.histograms import (CHANNELS, HUES, LEVELS, SHAPE, UNIT,
                                                      Sampled)
from img_recog.recognition.fitting.limits import TIE
from img_recog.recognition.fitting.score import Score
from img_recog.recognition.fitting.volume import Box, SummedVolume, box_of, edges_of

PIXELS, FRAMES, MARGIN = OBJECTIVES = 'pixels', 'frames', 'margin'
# how far a bound may be beyond the outermost sample where there is none of another color
_MOST_BEYOND = (10, 60, 60)
# the objective `margin`: so many levels of hue, saturation and value together, of which the
# largest is chosen that keeps this share of F1
_MARGIN_STEP, _MARGINS, _KEPT = (1, 4, 4), 12, 0.95
# weights of recall among which the objective `frames` chooses
_BETAS = 1.0, 0.25, 0.5, 2.0, 4.0
_WORST = 0.5         # or precision; below, bounds are of no use
TIMES_ADVICE = 'correct the times, or mark the color in a frame'


class Fit(NamedTuple):
    """Bounds of a color.

    margin: how many levels of hue, saturation and value the samples may move until the nearest
    bound cuts them off, or lets others in; None for one that has no such bound.
    """

    box: Box
    score: Score
    margin: Tuple[Optional[int], ...]


def score_of(box: Box, positive: SummedVolume, negative: SummedVolume) -> Score:
    """Return the score of bounds in pixels; positive, negative: of those in Sampled."""
    inside, wrong = (int(each.count(edges_of(box, HUES))) for each in (positive, negative))
    return Score(inside // UNIT, wrong // UNIT, (positive.total - inside) // UNIT)


def fits(color: str, sampled: Sampled, objective: str = PIXELS, by_times: bool = False
         ) -> List[Fit]:
    """Return the bounds that separate a color best; for FRAMES, several to choose from.

    Bounds are in the middle between the two where that makes no difference to the samples, but not
    farther beyond the samples than 10 hues and 60 levels.
    by_times: whether the samples of the color are estimated from times.
    Raises UserError if no pixel is a sample of the color, or no bounds separate it.
    """
    if not len(sampled.positive.counts):
        if by_times:
            raise UserError('frames with {} have not more of any color than those without '
                            'it'.format(color), TIMES_ADVICE)
        raise UserError('no pixel is a sample of {}'.format(color), 'add a rectangle, a polygon, '
                        'a mask, or a range of time; what is ignored must not cover it')
    search, found = BoxSearch(*sampled, SHAPE), []
    for beta in _BETAS if objective == FRAMES else _BETAS[:1]:
        best = search.best(beta)
        if objective == MARGIN:
            best = _widest(search, best)
        scored = search.objective(beta)
        box, margin = _centered(scored, best.edges)
        fit = Fit(box, score_of(box, scored.positive, scored.negative), margin)
        if fit not in found:
            found.append(fit)
    # in other light, more has changed than the color: its recall is not known by times
    if (found[0].score.precision if by_times else found[0].score.f1) < _WORST:
        error = _inseparable(color, sampled, found[0])
        raise UserError(error.problem, TIMES_ADVICE) if by_times else error
    return found


def _widest(search: BoxSearch, best: Found) -> Found:
    """Return the best box with the largest margin that keeps most of F1."""
    low, high = 0, _MARGINS
    while low < high:
        middle = (low + high + 1) // 2
        hue, saturation, value = (middle * step for step in _MARGIN_STEP)
        found = search.best(1.0, (hue, saturation, value))
        if found.score >= _KEPT * best.score:
            low, best = middle, found._replace(score=best.score)
        else:
            high = middle - 1
    return best


def _centered(objective: Objective, edges: np.ndarray) -> Tuple[Box, Tuple[Optional[int], ...]]:
    """Return bounds in the middle between the smallest and the largest box that are as good.

    Also returns their margin, as in Fit.
    """
    least = float(objective.score(edges)) - TIE
    inner = _moved(objective, edges, least, -1, SHAPE)
    outer = _moved(objective, inner, least, 1, [2 * most for most in _MOST_BEYOND])
    edges, margin = inner.copy(), []
    for axis, (size, most) in enumerate(zip(SHAPE, _MOST_BEYOND)):
        nearest = []
        for side, sign in ((2 * axis, -1), (2 * axis + 1, 1)):
            free = sign * int(outer[side] - inner[side])
            if side % 2 and axis and outer[side] == size:
                edges[side] = size      # brighter or more saturated, up to the end of the scale
                continue
            beyond = min(free // 2, most)
            edges[side] = inner[side] + sign * beyond
            nearest.append(beyond)
        margin.append(min(nearest) if nearest else None)
    return box_of(_normal(edges), HUES), tuple(margin)


def _moved(objective: Objective, edges: np.ndarray, least: float, sign: int,
           most: Sequence[int]) -> np.ndarray:
    """Return the box after its sides were moved by turns as long as its score is not less.

    sign: 1 outwards, -1 inwards; most: levels of hue, saturation and value. Its first hue may be
    negative.
    """
    start, edges = edges, edges.copy()
    sides = [0, 1, 2, 3, 4, 5]
    while sides:
        for side in list(sides):
            # a level of hue is worth several of the others: all sides shall come equally far
            axis, step = side // 2, sign if side % 2 else -sign
            moved = np.tile(edges, (_MARGIN_STEP[axis], 1))
            moved[:, side] += step * np.arange(1, len(moved) + 1)
            moved = moved[[abs(each[side] - start[side]) <= most[axis] and _is_box(each)
                           for each in moved]]
            scores = objective.scores_along(
                axis, _normal(edges), _normal(moved)[:, 2 * axis:2 * axis + 2].T)
            good = int(np.logical_and.accumulate(scores >= least).sum())
            edges[side] += good * step
            if good < _MARGIN_STEP[axis]:
                sides.remove(side)
    return edges


def _is_box(edges: np.ndarray) -> bool:
    return (0 < edges[1] - edges[0] <= HUES
            and all(0 <= low < end <= LEVELS for low, end in (edges[2:4], edges[4:])))


def _normal(edges: np.ndarray) -> np.ndarray:
    """Return the same boxes with a first hue from 0 to HUES - 1."""
    edges = edges.copy()
    edges[..., :2] -= edges[..., :1] // HUES * HUES
    return edges


def _inseparable(color: str, sampled: Sampled, fit: Fit) -> UserError:
    """Return the error for a color that no bounds separate, with what overlaps."""
    common, *places = np.intersect1d(sampled.positive.indices, sampled.negative.indices,
                                     assume_unique=True, return_indices=True)
    own, others = (each.counts[place] for each, place in zip(sampled, places))
    most = int(common[np.minimum(own, others).argmax()]) if len(common) else 0
    hue, saturation, value = np.unravel_index(most, SHAPE)
    share = own.sum() / sampled.positive.counts.sum()
    return UserError(
        'no bounds separate {}: the best ones, {}, have a precision of {:.0%} and a recall of '
        '{:.0%}; {:.0%} of its pixels have a color that others have too, most at hue {}, '
        'saturation {}, value {}'.format(
            color, described(fit.box), fit.score.precision, fit.score.recall, share, hue,
            saturation, value),
        'label only pixels of the color, and all of them in a frame (or set unlabeled: ignored)')


def described(box: Box) -> str:
    """Return bounds as text.

    >>> described(Box((170, 10), (100, 255), (0, 255)))
    'hue 170-10, saturation 100-255, value 0-255'
    """
    return ', '.join('{} {}-{}'.format(name, *part) for name, part in zip(CHANNELS, box))


def as_parameters(color: str, box: Box) -> Dict[str, int]:
    """Return bounds as parameters of color_extract; the whole range of hues as users write it.

    >>> as_parameters('red', Box((0, 179), (100, 255), (0, 255)))['red_hue_max']
    180
    """
    values = {}
    for part, (low, high) in zip(CHANNELS, box):
        values['{}_{}_min'.format(color, part)] = low
        values['{}_{}_max'.format(color, part)] = (
            HUES if part == 'hue' and (low, high) == (0, HUES - 1) else high)
    return values
