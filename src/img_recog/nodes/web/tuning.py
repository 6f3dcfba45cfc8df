"""Changes parameters of other nodes by dynamic_reconfigure, without waiting for them."""
import contextlib
import threading
import time
from typing import Any, Callable, Dict, List, Mapping, Optional, Set

import rospy
import yaml
from dynamic_reconfigure import DynamicReconfigureCallbackException
from dynamic_reconfigure.client import Client

from img_recog import files
from img_recog.errors import UserError, one_line
from img_recog.recognition import parameter_file
from img_recog.ros import parameters
from img_recog.ros.master import master

CONNECT_TIMEOUT_S = 2.0
RETRY_PERIOD_S = 1.0
ANSWER_TIMEOUT_S, _POLL_S = 10.0, 0.05
FOLDER_ADVICE = 'start it in a folder where files can be written'
_FIRST = '_hue_min'             # each color has it
saving = threading.Lock()       # of all robots: a name is free until its file is there


class Tuning:
    """Parameters of a node that can be changed while it runs.

    It connects while somebody looks, from a separate thread, which also sends what is changed: of
    several changes of a parameter that wait, the last one is sent.
    """

    def __init__(self, node: str):
        """Do nothing yet; node: the resolved name of the node."""
        self.node = node
        self._is_told = False       # that the node does not answer
        self._condition = threading.Condition()
        self._watching: Set[object] = set()
        self._thread: Optional[threading.Thread] = None
        self._changes: Dict[str, Any] = {}
        self._is_sending = False
        self._values: Dict[str, Any] = {}
        self.revision = 0

    def watch(self, page: object, is_watched: bool) -> None:
        """Connect for a page, or disconnect after the last one, soon and in another thread."""
        with self._condition:
            (self._watching.add if is_watched else self._watching.discard)(page)
            if self._watching and self._thread is None:
                self._thread = threading.Thread(target=self._run, daemon=True)
                self._thread.start()
            self._condition.notify()

    def values(self) -> Dict[str, Any]:
        """Return the values of all parameters; empty as long as the node does not answer.

        revision: changes whenever they change.
        """
        return self._values

    def change(self, **values: Any) -> None:
        """Change parameters, soon and in another thread."""
        with self._condition:
            self._changes.update(values)
            self._condition.notify()

    def is_settled(self) -> bool:
        """Return whether `values` has all that was changed."""
        with self._condition:
            return not self._changes and not self._is_sending

    def _run(self) -> None:
        while self._goes_on():
            try:
                # closed before the next one is made: rospy sends no latched messages to a second
                # subscriber of a process
                with contextlib.closing(self._connect()) as client:
                    self._is_told = False
                    while self._is_wanted():
                        self._send(client)
            except Exception as error:      # rospy raises more than it documents
                if not self._is_told and self._is_there():
                    rospy.logwarn('the parameters of %s: %s', self.node, one_line(error))
                    self._is_told = True
                with self._condition:
                    self._condition.wait_for(lambda: not self._watching, RETRY_PERIOD_S)

    def _is_there(self) -> bool:
        """Return whether the master knows the node; a demo can be without recognition."""
        with contextlib.suppress(OSError):
            return master.calls().ask('lookupNode', self.node) is not None
        return False

    def _is_wanted(self) -> bool:
        return bool(self._watching) and not rospy.is_shutdown()

    def _goes_on(self) -> bool:
        """Return whether the thread is still needed; if not, the next `watch` starts another."""
        with self._condition:
            if not self._is_wanted():
                # a change that could not be sent must not come much later
                self._thread, self._values, self._changes = None, {}, {}
            return self._thread is not None

    def _connect(self) -> Client:
        # update_configuration would wait for ever without descriptions, and would not know the
        # parameters of those that are being read: the callback comes at their end
        described = threading.Event()
        client = Client(self.node, timeout=CONNECT_TIMEOUT_S, config_callback=self._received,
                        description_callback=lambda _: described.set())
        if not described.wait(CONNECT_TIMEOUT_S):
            client.close()
            raise rospy.ROSException('no descriptions came')
        return client

    def _send(self, client: Client) -> None:
        """Send the changes that wait, or wait for some."""
        with self._condition:
            self._condition.wait_for(lambda: self._changes or not self._watching,
                                     RETRY_PERIOD_S)
            changes, self._changes = self._changes, {}
            self._is_sending = bool(changes)
        if not changes:
            return
        try:
            self._received(client.update_configuration(changes))
        except (DynamicReconfigureCallbackException, rospy.ROSException, OSError):
            with self._condition:       # again with the next connection
                self._changes = {**changes, **self._changes}
            raise
        finally:
            self._is_sending = False

    def _received(self, values: Dict[str, Any]) -> None:
        self._values = {name: value for name, value in values.items() if name != 'groups'}
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
