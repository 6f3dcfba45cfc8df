"""Bounds that are offered for marked samples."""
from typing import Dict, NamedTuple, Optional

from img_recog.errors import UserError, one_line
from img_recog.recognition.areas import to_hsv
from img_recog.recognition.fitting import bounds
from img_recog.recognition.fitting.histograms import UNIT, Counter, of_color
from img_recog.recognition.fitting.marked import Marked
from img_recog.recognition.fitting.volume import Box


class Offer(NamedTuple):
    """Bounds of a color, or the problem why there are none.

    marked_inside, others_inside: the shares of the marked pixels and of all others that are within
    them, 0 to 1.
    """

    box: Optional[Box]
    marked_inside: float = 0.0
    others_inside: float = 0.0
    problem: str = ''


def offers(marked: Marked) -> Dict[str, Offer]:
    """Return what is offered for each color that has samples, as fit_colors.py finds it."""
    counter = Counter()
    for name in marked.pictures:
        labels = marked.labels(name)
        if labels.has_regions:
            counter.add_frame(labels.parts(to_hsv(marked.image(name), 'bgr8')))
    histograms, found = counter.result(), {}
    for color in marked.colors:
        sampled = of_color(histograms, color)
        try:
            fit, = bounds.fits(color, sampled)
            others_px = max(1, int(sampled.negative.counts.sum()) // UNIT)
            found[color] = Offer(fit.box, fit.score.recall, fit.score.wrong / others_px)
        except UserError as error:
            found[color] = Offer(None, problem=one_line(error))
    return found
