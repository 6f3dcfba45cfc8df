"""Changes parameters of other nodes by dynamic_reconfigure, without waiting for them."""
import threading
import time
from typing import Any, Callable, Dict, List, Mapping, Set

import rospy
import yaml
from dynamic_reconfigure.encoding import decode_config, encode_config
from dynamic_reconfigure.msg import Config
from dynamic_reconfigure.srv import Reconfigure

from img_recog import files
from img_recog.errors import UserError, one_line
from img_recog.nodes.web.measurements import WatchedTopics
from img_recog.recognition import parameter_file
from img_recog.ros import parameters

RETRY_PERIOD_S = 1.0
ANSWER_TIMEOUT_S, _POLL_S = 10.0, 0.05
FOLDER_ADVICE = 'start it in a folder where files can be written'
_FIRST = '_hue_min'             # each color has it
saving = threading.Lock()       # of all robots: a name is free until its file is there


class Tuning(WatchedTopics):
    """Parameters of a node that can be changed while it runs.

    It listens while somebody looks. Another thread sends what is changed: of several changes of a
    parameter that wait, the last one is sent.
    """

    def __init__(self, node: str):
        """Do nothing yet; node: the resolved name of the node."""
        super().__init__()
        self.node = node
        self._topics = [(node + '/parameter_updates', Config, self._received)]
        self._call = rospy.ServiceProxy(node + '/set_parameters', Reconfigure)
        self._is_told = False       # that the node does not answer
        self._pages: Set[object] = set()
        self._waiting = threading.Lock()        # of the next two
        self._changes: Dict[str, Any] = {}
        self._is_sending = False
        self._values: Dict[str, Any] = {}
        self.revision = 0

    def watch_for(self, page: object, is_watched: bool) -> None:
        """Listen for a page, or end it after the last one, soon and in another thread."""
        (self._pages.add if is_watched else self._pages.discard)(page)
        self.watch(bool(self._pages))

    def values(self) -> Dict[str, Any]:
        """Return the values of all parameters; empty as long as the node does not answer.

        revision: changes whenever they change.
        """
        return self._values

    def change(self, **values: Any) -> None:
        """Change parameters, soon and in another thread."""
        with self._waiting:
            self._changes.update(values)
            if not self._is_sending:
                self._is_sending = True
                threading.Thread(target=self._send, daemon=True).start()

    def is_settled(self) -> bool:
        """Return whether `values` has all that was changed."""
        return not self._is_sending

    def _send(self) -> None:
        """Send changes until none waits; again if that fails, while somebody looks."""
        while True:
            with self._waiting:
                changes, self._changes = self._changes, {}
                if not changes or rospy.is_shutdown():
                    self._is_sending = False
                    return
            try:
                self._received(self._call(encode_config(changes)).config)
                self._is_told = False
            except (rospy.ServiceException, rospy.ROSException, OSError) as error:
                if not self._is_told:
                    self._is_told = True
                    rospy.logwarn('the parameters of %s: %s', self.node, one_line(error))
                time.sleep(RETRY_PERIOD_S)
                with self._waiting:     # one that could not be sent must not come much later
                    if self._pages:
                        self._changes = {**changes, **self._changes}

    def _forget(self) -> None:
        super()._forget()
        self._values = {}

    def _received(self, msg: Config) -> None:
        self._values = dict(decode_config(msg))
        self.revision += 1


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


def color_names_in(values: Mapping[str, Any]) -> List[str]:
    """Return the names of the colors for which there are parameters, in their order."""
    return [name[:-len(_FIRST)] for name in values if name.endswith(_FIRST)]
