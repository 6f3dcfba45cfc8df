"""The processes on this computer that subscribe to the topics of this node."""
import threading
import time
from typing import Any, Dict, Optional

import rosgraph
import rospy

from img_recog import timed_xmlrpc
from img_recog.timed_xmlrpc import Master

_PERIOD_S, _TIMEOUT_S = 1.0, 0.5        # of wall time


class LocalSubscribers:
    """Asks master and nodes once a second, in a thread of its own.

    pids: of the processes, by the names of the nodes; replaced, never changed.
    """

    def __init__(self) -> None:
        """Start to ask."""
        self.pids: Dict[str, int] = {}
        self._uris: Dict[str, str] = {}
        self._master = Master(rosgraph.get_master_uri(), rospy.get_name(), _TIMEOUT_S)
        threading.Thread(target=self._run, name='local subscribers', daemon=True).start()

    def _run(self) -> None:
        while not rospy.is_shutdown():
            time.sleep(_PERIOD_S)
            try:
                self._update()
            except OSError:     # the master does not answer: those that were known stay
                continue

    def _update(self) -> None:
        published, subscribed, _ = self._master.ask('getSystemState') or ((), (), ())
        node = rospy.get_name()
        own = {topic for topic, nodes in published if node in nodes}
        names = {name for topic, nodes in subscribed if topic in own for name in nodes} - {node}
        uris = {name: self._master.ask('lookupNode', name) or '' for name in names}
        asked = {name: _pid(uri, node) for name, uri in uris.items()
                 if uri != self._uris.get(name)}
        self.pids = {**{name: pid for name, pid in self.pids.items() if name in uris},
                     **{name: pid or 0 for name, pid in asked.items()}}
        # one that has not answered is asked again
        self._uris = {name: uri for name, uri in uris.items() if asked.get(name, 0) is not None}


def _pid(uri: str, caller: str) -> Optional[int]:
    """Return the PID of a node; 0 if it is on another computer, None if it does not answer."""
    host, _ = rosgraph.network.parse_http_host_and_port(uri or 'http://unknown:0')
    if not rosgraph.network.is_local_address(host):
        return 0
    try:
        answer: Any = timed_xmlrpc.server(uri, _TIMEOUT_S).getPid(caller)
        return int(answer[2])
    except (*timed_xmlrpc.ERRORS, IndexError, TypeError, ValueError):
        return None
