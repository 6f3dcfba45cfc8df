"""Keeps the parameters of a node outside of its process, for scripts/respawn.py; without rospy."""
import http.client
import signal
import threading
import time
import xmlrpc.client
from typing import Any, Callable, Dict, Iterable, Optional, Sequence, Tuple

import rosgraph
from rosgraph import names

_TIMEOUT_S, _RETRY_S = 1.0, 0.5     # of a call
_READ_LIMIT_S = 20.0    # a master that does not answer for so long is asked no more
_POLL_PERIOD_S = 0.1


class KeptParameters:
    """The parameters that a node reads, kept for a new master.

    The master is called in threads: one that does not answer delays neither a start nor a signal.
    Its methods raise nothing: a node whose parameters are not known is just started.
    """

    def __init__(self, command: Sequence[str], say: Callable[[str], None],
                 signals: Iterable[signal.Signals]) -> None:
        """Call no master yet.

        command: of the node; its arguments and the environment say its name and its master.
        say: logs a line, in any thread.
        signals: are not handled by the threads.

        Raises ValueError if the command gives no address after __master:=.
        """
        name = names.load_mappings(command).get('__name')
        self._node = name and names.ns_join(names.get_ros_namespace(argv=command), name)
        self._uri = rosgraph.get_master_uri(argv=command)
        self._say, self._signals = say, tuple(signals)
        self._values: Optional[Dict[str, Any]] = None   # by their full names
        self._origin: Tuple[Any, Any] = (None, None)    # the identity of the master that has them
        self._thread = threading.Thread()

    def keep(self) -> None:
        """Begin to read the parameters, unless they are known."""
        if self._node and self._values is None and not self._thread.is_alive():
            self._start(self._read)

    def set_again(self, is_ended: Callable[[], object]) -> None:
        """If the parameters are known, wait for a master and set those that a new one lacks.

        is_ended: returns whether to wait no longer.
        """
        if self._values is not None and not is_ended():
            self._start(self._set_when_possible)
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

    def _read(self) -> None:
        end_s = time.monotonic() + _READ_LIMIT_S
        while self._values is None and time.monotonic() < end_s:
            try:
                with _Master(self._uri, self._node) as master:
                    origin = master.identity()
                    values = master.private_parameters()
                    for name in ('/use_sim_time', master.ask('searchParam', 'robot_description')):
                        value = name and master.ask('getParam', name)
                        if value is not None:
                            values[name] = value
                self._origin, self._values = origin, values
            except Exception:           # also what no master would answer
                time.sleep(_RETRY_S)

    def _set_when_possible(self) -> None:
        is_said = False
        while True:
            try:
                self._set()
                return
            except OSError as error:    # a timeout, too
                if not is_said:
                    self._say('waits for the master at {} to answer: {}'.format(
                        self._uri, error.strerror or error))
                is_said = True
                time.sleep(_RETRY_S)
            except Exception as error:
                self._say('sets no parameters: {!r}'.format(error)[:200])
                return

    def _set(self) -> None:
        """Set what a new master lacks; on the same one, the user may have deleted it."""
        with _Master(self._uri, self._node) as master:
            origin = master.identity()
            if origin != self._origin or not origin[1]:
                values = self._values or {}
                missing = [name for name in values if master.ask('hasParam', name) is False]
                count = sum(master.ask('setParam', name, values[name]) is not None
                            for name in missing)
                self._origin = origin
                if count:
                    self._say('has set {} parameters on a new master'.format(count))


class TimedTransport(xmlrpc.client.Transport):
    """XML-RPC calls with a time limit."""

    def make_connection(self, host: Any) -> http.client.HTTPConnection:
        connection = super().make_connection(host)
        connection.timeout = _TIMEOUT_S
        return connection


class _Master:
    """Calls to a master. Raises OSError if it does not answer."""

    def __init__(self, uri: str, node: str) -> None:
        self._proxy = xmlrpc.client.ServerProxy(uri, transport=TimedTransport())
        self._node = node

    def __enter__(self) -> '_Master':
        return self

    def __exit__(self, *_: object) -> None:
        self._proxy('close')()

    def ask(self, method: str, *arguments: Any) -> Any:
        """Return the value, None if there is none or XML-RPC cannot transmit it."""
        try:
            code, _, value = getattr(self._proxy, method)(self._node, *arguments)
        except OSError:
            raise
        except http.client.HTTPException as error:
            raise OSError(str(error))
        except Exception:       # an integer of more than 32 bits, for example
            return None
        return value if code == 1 else None

    def identity(self) -> Tuple[Any, Any]:
        """Return what another master does not have: the process id, and the id of its roscore."""
        return self.ask('getPid'), self.ask('getParam', '/run_id')

    def private_parameters(self) -> Dict[str, Any]:
        """Return the node's parameters by their full names, without those that are unreadable."""
        prefix = self._node + '/'
        found = self.ask('getParam', self._node)
        if isinstance(found, dict):
            return {prefix + key: value for key, value in found.items()}
        # none at all, or one of them is unreadable
        values = {name: self.ask('getParam', name) for name in self.ask('getParamNames') or ()
                  if name.startswith(prefix)}
        return {name: value for name, value in values.items() if value is not None}
