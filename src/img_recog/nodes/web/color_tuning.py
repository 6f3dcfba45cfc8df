"""The colors of a color_extract, as a page changes them."""
import threading
import time
from typing import Any, Callable, Dict, List, Mapping

import yaml

from img_recog import files
from img_recog.errors import UserError
from img_recog.nodes.web.tuning import Tuning
from img_recog.recognition import parameter_file
from img_recog.ros import parameters

saving = threading.Lock()       # of all robots: a name is free until its file is there
FOLDER_ADVICE = 'start it in a folder where files can be written'
ANSWER_TIMEOUT_S, _POLL_S = 10.0, 0.05
_FIRST = '_hue_min'             # each color has it


def color_names_in(values: Mapping[str, Any]) -> List[str]:
    """Return the names of the colors for which there are parameters, in their order."""
    return [name[:-len(_FIRST)] for name in values if name.endswith(_FIRST)]


class ColorTuning(Tuning):
    """Parameters of color_extract, and a file of them."""

    def replace(self, changes: Mapping[str, Any]) -> Dict[str, Any]:
        """Change parameters, wait until the node has them, and return what they were before.

        Raises UserError if it does not answer.
        """
        before = self.values()
        if not set(changes) <= set(before):
            raise self._silence()
        self.change(**changes)
        if not wait_until(self.is_settled):
            raise self._silence()
        return {name: before[name] for name in changes}

    def as_file(self) -> str:
        """Return the parameters as the text of a file, '' if the node does not answer.

        With those that only a start of the node reads.
        """
        values = self.values()
        names = color_names_in(values)
        if not names:
            return ''
        try:
            given = parameters.value(self.node) or {}
        except OSError:
            raise self._silence()
        at_start = {name: given[name] for name in parameter_file.node_only(names)
                    if name in given and name != parameter_file.COLORS_FILE}
        return yaml.safe_dump({parameter_file.COLORS: names, **at_start, **values},
                              sort_keys=False)

    def save(self) -> str:
        """Save the parameters with the last changes as a file; return its path."""
        is_settled = wait_until(self.is_settled)
        text = self.as_file()
        if not text or not is_settled:
            raise self._silence()
        with saving:
            path = files.free_output_path('colors', '.yaml')
            with files.atomic_write([path], FOLDER_ADVICE) as (file,):
                file.write(text.encode())
        return path

    def _silence(self) -> UserError:
        return UserError('{} does not answer'.format(self.node), 'start it')


def wait_until(condition: Callable[[], Any]) -> Any:
    """Return the first true value of a condition, or its last value after a time limit."""
    end_s = time.monotonic() + ANSWER_TIMEOUT_S
    value = condition()
    while not value and time.monotonic() < end_s:
        time.sleep(_POLL_S)
        value = condition()
    return value
