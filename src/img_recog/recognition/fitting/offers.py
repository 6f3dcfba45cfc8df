"""Bounds that are offered for marked samples."""
import os
import pickle
import subprocess
import sys
from typing import Dict, NamedTuple, Optional

from img_recog.errors import UserError, one_line
from img_recog.recognition.areas import to_hsv
from img_recog.recognition.fitting import bounds
from img_recog.recognition.fitting.histograms import UNIT, Counter, of_color
from img_recog.recognition.fitting.marked import Marked
from img_recog.recognition.fitting.volume import Box

_NICENESS = 5
_PROGRAM = 'from {0} import main; main()'.format(__name__)


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
            others_px = max(1, int(sampled.negative.sum()) // UNIT)
            found[color] = Offer(fit.box, fit.score.recall, fit.score.wrong / others_px)
        except UserError as error:
            found[color] = Offer(None, problem=one_line(error))
    return found


def offers_of_a_process(marked: Marked, timeout_s: float) -> Dict[str, Offer]:
    """Return what `offers` does, from a process that is ended after a time.

    The search takes hundreds of MB for some seconds. Raises UserError if there is no result.
    """
    path = os.pathsep.join(filter(None, sys.path))
    try:
        done = subprocess.run(
            [sys.executable, '-c', _PROGRAM], input=pickle.dumps(marked), stdout=subprocess.PIPE,
            stderr=subprocess.PIPE, timeout=timeout_s, check=False,
            env={**os.environ, 'PYTHONPATH': path})
    except subprocess.TimeoutExpired:
        raise UserError('the search of bounds took more than {:g} s'.format(timeout_s),
                        'mark fewer pictures')
    except OSError as error:
        raise UserError('cannot search bounds: {}'.format(one_line(error)))
    if done.returncode:
        lines = done.stderr.decode(errors='replace').strip().split('\n')
        raise UserError('the search of bounds has ended: exit code {}, {}'.format(
            done.returncode, one_line(lines[-1])))
    return pickle.loads(done.stdout)


def main() -> None:
    """Search for `offers_of_a_process`."""
    os.nice(_NICENESS)
    sys.stdout.buffer.write(pickle.dumps(offers(pickle.load(sys.stdin.buffer))))
