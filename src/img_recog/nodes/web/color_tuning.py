"""The colors of a color_extract, as a page changes them."""
import threading
import time
from typing import Any, Callable, Dict, List, Mapping

import cv2
import numpy as np
import yaml

from img_recog import files
from img_recog.errors import UserError
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.tuning import Tuning
from img_recog.recognition.parameter_file import COLORS
from img_recog.recognition.proposal import propose_bounds

_saving = threading.Lock()      # of all robots: a name is free until its file is there
_FOLDER_ADVICE = 'start it in a folder where files can be written'
_ANSWER_TIMEOUT_S, _POLL_S = 10.0, 0.05
_FIRST = '_hue_min'             # each color has it


def color_names_in(values: Mapping[str, Any]) -> List[str]:
    """Return the names of the colors for which there are parameters, in their order."""
    return [name[:-len(_FIRST)] for name in values if name.endswith(_FIRST)]


class ColorTuning(Tuning):
    """Parameters of color_extract, a proposal of bounds, and a file."""

    def __init__(self, node: str, pictures: PictureTopics):
        """Do nothing yet; node: the resolved name of the node."""
        super().__init__(node)
        self._pictures = pictures

    def propose(self, topic: str, x: float, y: float, color: str) -> Dict[str, int]:
        """Set bounds of a color around that in a picture; return them.

        Waits for both for a moment: a page that has just opened a tab shows the last picture, but
        its topic and the parameters may not be followed again yet.
        """
        picture = _wait(lambda: self._pictures.latest(topic))
        if picture is None:
            raise UserError('there is no picture of {}'.format(topic[:100]),
                            'click again when there is one')
        if not _wait(lambda: color in color_names_in(self.values())):
            raise UserError('{} does not answer'.format(self.node), 'start it')
        image = cv2.imdecode(np.frombuffer(picture.jpeg, np.uint8), cv2.IMREAD_COLOR)
        bounds = propose_bounds(image, x, y)
        self.change(**{'{}_{}'.format(color, part): value for part, value in bounds.items()})
        return bounds

    def as_file(self) -> str:
        """Return the parameters as the text of a file, '' if the node does not answer."""
        values = self.values()
        names = color_names_in(values)
        return yaml.safe_dump({COLORS: names, **values}, sort_keys=False) if names else ''

    def save(self) -> str:
        """Save the parameters with the last changes as a file; return its path."""
        is_settled = _wait(self.is_settled)
        text = self.as_file()
        if not text or not is_settled:
            raise UserError('{} does not answer'.format(self.node), 'start it')
        with _saving:
            path = files.free_output_path('colors', '.yaml')
            with files.atomic_write([path], _FOLDER_ADVICE) as (file,):
                file.write(text.encode())
        return path


def _wait(condition: Callable[[], Any]) -> Any:
    """Return the first true value of a condition, or its last value after a time limit."""
    end_s = time.monotonic() + _ANSWER_TIMEOUT_S
    value = condition()
    while not value and time.monotonic() < end_s:
        time.sleep(_POLL_S)
        value = condition()
    return value
