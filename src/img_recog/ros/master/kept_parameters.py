"""Keeps the parameters of a node outside of its process, for scripts/respawn.py; without rospy."""
import signal
import threading
import time
from typing import Any, Callable, Dict, Iterable, Optional, Sequence, Tuple

import rosgraph
from rosgraph import names

from img_recog.timed_xmlrpc import Master

_READ_LIMIT_S = 20.0    # a master that does not answer for so long is asked no more
_POLL_PERIOD_S = 0.1


class KeptParameters:
    """The parameters that a node reads, kept for a new master. node: its resolved name, or ''.

    The master is called in threads: one that does not answer delays neither a start nor a signal.
    Its methods raise nothing: a node whose parameters are not known is just started.
    """

    def __init__(self, command: Sequence[str], say: Callable[[str], None],
                 signals: Iterable[signal.Signals], timeout_s: float = 1.0,
                 retry_s: float = 0.5) -> None:
        """Call no master yet.

        command: of the node; its arguments and the environment say its name and its master.
        say: logs a line, in any thread.
        signals: are not handled by the threads.
        timeout_s, retry_s: the time limit of a call, and the time before it is repeated.

        Raises ValueError if the command gives no address after __master:=.
        """
        name = names.load_mappings(command).get('__name', '')
        self.node = name and names.ns_join(names.get_ros_namespace(argv=command), name)
        self._uri = rosgraph.get_master_uri(argv=command)
        self._say, self._signals = say, tuple(signals)
        self._timeout_s, self._retry_s = timeout_s, retry_s
        self._values: Optional[Dict[str, Any]] = None   # by their full names
        self._origin: Tuple[Any, Any] = (None, None)    # the identity of the master that has them
        self._thread = threading.Thread()

    @property
    def are_known(self) -> bool:
        """Whether the parameters were read."""
        return self._values is not None

    def keep(self) -> None:
        """Begin to read the parameters, unless they are known."""
        if self.node and not self.are_known and not self._thread.is_alive():
            self._start(self._read)

    def set_again(self, is_ended: Callable[[], object]) -> None:
        """If the parameters are known, wait for a master and set those that a new one lacks.

        is_ended: returns whether to wait no longer; called in any thread.
        """
        if self.are_known and not is_ended():
            self._start(lambda: self._set_when_possible(is_ended))
            while self._thread.is_alive() and not is_ended():
                self._thread.join(_POLL_PERIOD_S)

    def _start(self, target: Callable[[], None]) -> None:
        thread = threading.Thread(target=target, daemon=True)
        signal.pthread_sigmask(signal.SIG_BLOCK, self._signals)
        try:
            thread.start()
            self._thread = thread
        except RuntimeError:        # too many threads
            pass
        finally:
            signal.pthread_sigmask(signal.SIG_UNBLOCK, self._signals)

    def _master(self) -> Master:
        return Master(self._uri, self.node, self._timeout_s)

    def _read(self) -> None:
        end_s = time.monotonic() + _READ_LIMIT_S
        while not self.are_known and time.monotonic() < end_s:
            try:
                with self._master() as master:
                    origin = _identity(master)
                    values = {**_private_parameters(master, self.node),
                              **master.shared_parameters()}
                self._origin, self._values = origin, values
            except Exception:           # also what no master would answer
                time.sleep(self._retry_s)

    def _set_when_possible(self, is_ended: Callable[[], object]) -> None:
        is_said = False
        while not is_ended():
            try:
                self._set()
                return
            except OSError as error:    # a timeout, too
                if not is_said:
                    self._say('waits for the master at {} to answer: {}'.format(
                        self._uri, error.strerror or error))
                is_said = True
                time.sleep(self._retry_s)
            except Exception as error:
                self._say('sets no parameters: {!r}'.format(error)[:200])
                return

    def _set(self) -> None:
        """Set what a new master lacks; on the same one, the user may have deleted it."""
        with self._master() as master:
            origin = _identity(master)
            if origin != self._origin or not origin[1]:
                count = master.set_missing(self._values or {})
                self._origin = origin
                if count:
                    self._say('has set {} parameters on a new master'.format(count))


def _identity(master: Master) -> Tuple[Any, Any]:
    """Return what another master does not have: the process id, and the id of its roscore."""
    return master.ask('getPid'), master.ask('getParam', '/run_id')


def _private_parameters(master: Master, node: str) -> Dict[str, Any]:
    """Return a node's parameters by their full names, without those that are unreadable."""
    prefix = node + '/'
    found = master.ask('getParam', node)
    if isinstance(found, dict):
        return {prefix + key: value for key, value in found.items()}
    # none at all, or one of them is unreadable
    values = {name: master.ask('getParam', name) for name in master.ask('getParamNames') or ()
              if name.startswith(prefix)}
    return {name: value for name, value in values.items() if value is not None}
