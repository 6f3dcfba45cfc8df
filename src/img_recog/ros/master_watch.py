"""Notices a new master, and registers the node again."""
import threading
import xmlrpc.client
from typing import Any, Callable, Dict, Optional, Tuple

import rosgraph
import rospy

from img_recog.errors import one_line
from img_recog.ros import parameters, timed_xmlrpc
from img_recog.ros.timed_xmlrpc import Master
from img_recog.ros.transport import registration
from img_recog.ros.transport.switch import is_plain

_PERIOD_S = 1.0
_MAX_TIMEOUTS = 3       # a busy master may miss one; a refused connection is reported at once
_STOP_TIMEOUT_S = 0.5


class MasterWatch:
    """Polls the master; registers the node again when the master does not know it.

    That is so after a restart of the master. Its parameters are lost then: the private ones of
    this node, /use_sim_time and robot_description are kept here and set again, except those that
    the new master has.
    """

    def __init__(self, timeout_s: float = 1.0) -> None:
        """timeout_s: of a call to the master."""
        self._uri, self._name = rosgraph.get_master_uri(), rospy.get_name()
        self._master = Master(self._uri, self._name, timeout_s)
        self._private: Dict[str, Any] = {}
        self._shared: Optional[Dict[str, Any]] = None
        self._failures = 0
        self._is_gone = self._is_registering = self._is_unreadable = False
        self._ended = threading.Event()
        self._lock = threading.Lock()       # held during a poll

    @property
    def has_ended(self) -> bool:
        """Whether it watches no longer."""
        return self._ended.is_set()

    def start(self) -> None:
        """Watch in a separate thread."""
        threading.Thread(target=self._run, name='master watch', daemon=True).start()

    def stop(self) -> None:
        """End; nothing is registered after this."""
        self._ended.set()
        if self._lock.acquire(timeout=_STOP_TIMEOUT_S):
            self._lock.release()

    def _run(self) -> None:
        while not self.has_ended:
            with self._lock:
                if not self.has_ended and not rospy.core.is_shutdown_requested():
                    self.poll()
            self._ended.wait(_PERIOD_S)

    def poll(self) -> None:
        """Look once whether the master knows the node, and do what is needed."""
        try:
            self._poll()
        except timed_xmlrpc.ERRORS as error:
            self._failures += 1
            is_slow = isinstance(error, TimeoutError) or 'timed out' in str(error)
            if not self._is_gone and (not is_slow or self._failures >= _MAX_TIMEOUTS):
                self._is_gone = True
                rospy.logwarn('the master at %s does not answer: %s; this node goes on, and '
                              'registers again when there is a master', self._uri, one_line(error))

    def _poll(self) -> None:
        (code, _, uri), private = self._ask()
        self._failures = 0
        if code == 1 and uri != rospy.get_node_uri():
            self._ended.set()       # another node has this name, and this one is shut down
        elif code == 1 and not self._is_registering and not self._is_gone:
            self._keep(private)
        else:
            # one that was gone may be a new one also if it has the node: rospy sends it what the
            # node has subscribed or advertised meanwhile, and nothing else
            self._register()

    def _ask(self) -> Tuple[Any, Optional[Dict[str, Any]]]:
        """Return the answer to lookupNode, and the private parameters, None if unreadable."""
        multi = xmlrpc.client.MultiCall(self._master.proxy)
        multi.lookupNode(self._name, self._name)
        multi.getParam(self._name, self._name)
        try:
            results: Any = multi()
            node, (has_private, _, private) = results
        except xmlrpc.client.Fault as fault:
            # the master has answered: it cannot send an integer of more than 32 bits, for example
            node = self._master.proxy.lookupNode(self._name, self._name)
            if not self._is_unreadable:
                self._is_unreadable = True
                rospy.logwarn('%s', parameters.unreadable(self._name, fault))
            return node, None
        self._is_unreadable = False
        return node, private if has_private == 1 and isinstance(private, dict) else {}

    def _keep(self, private: Optional[Dict[str, Any]]) -> None:
        if private is not None:
            self._private = private
        if self._shared is None:
            self._shared = self._master.shared_parameters()

    def _register(self) -> None:
        self._is_registering = True         # until all of it has succeeded
        values = {'{}/{}'.format(self._name, key): value for key, value in self._private.items()}
        count = self._master.set_missing({**values, **(self._shared or {})})
        topics, services = registration.register_again(self._master.call)
        self._is_registering = self._is_gone = False
        rospy.loginfo('a master answers at %s: registered again, topics %d, services %d, '
                      'parameters %d', self._uri, topics, services, count)


def start(on_shutdown: Callable[[Callable[[], None]], None]) -> None:
    """Watch the master from now on, unless plain rospy is wanted; for lifecycle.run.

    on_shutdown: registers a hook for the begin of the shutdown.
    """
    if not is_plain('registration'):
        watch = MasterWatch()
        on_shutdown(watch.stop)
        watch.start()
