"""The nodes between the sensors and the answers to them, in lockstep."""
import contextlib
import time
from typing import Callable, Dict, Mapping

import rosgraph
import rospy

from img_recog.errors import UserError, one_line
from img_recog.ros.master.connections import Connections
from img_recog.ros.transport.redelivery import Redelivery

_CHECK_PERIOD_S = 1.0       # of wall time, between two looks for nodes that came back


class AnsweringNodes:
    """Knows whether these nodes are connected, and gives those that come back what they missed.

    In what follows, types are those of the topics of the answers, by their names.
    """

    def __init__(self, redelivery: Redelivery, report: Callable[[float, str], None]):
        """redelivery: of the messages of the sensors; report: logs for whom time stands."""
        self._redelivery, self._report = redelivery, report
        self._connections = Connections(rosgraph.get_master_uri(), rospy.get_name())
        self._uris: Dict[str, str] = {}         # of the nodes, by their names
        self._checked_s, self._is_renewed = 0.0, False

    def begins(self, time_s: float, types: Mapping[str, str]) -> bool:
        """Return whether all are connected at the start; report.

        Raises UserError if a topic would be answered by this node itself.
        """
        with contextlib.suppress(OSError):
            own = sorted(self._connections.own() & set(types))
            if own:
                raise UserError(
                    'lockstep: {} is published by the simulator itself'.format(', '.join(own)),
                    'name topics that are published by the nodes to wait for, such as cmd_vel')
        if not self._are_connected(time_s, types):
            return False
        self._uris = self._connections.uris
        with contextlib.suppress(OSError):
            for topic, others in self._connections.shared():
                rospy.logwarn('lockstep: %s is published by %s too: nodes answer their messages '
                              'as well; stop them', topic, ', '.join(others))
        return True

    def clear(self) -> None:
        """Forget what was sent: it is answered."""
        self._redelivery.clear()
        self._is_renewed = False

    def deliver_again(self, time_s: float, types: Mapping[str, str], sent_s: float) -> None:
        """Send what was not answered to nodes that came back; to be called again and again.

        One that hears only from other nodes has lost what these have sent. So, after a time in
        which what is on its way can arrive, all get the message of the sensors again.
        """
        now_s, is_needed = time.monotonic(), self._redelivery.is_needed()
        if not is_needed and now_s < max(self._checked_s, sent_s) + _CHECK_PERIOD_S:
            return
        self._checked_s = now_s
        if self._is_renewed:
            self._is_renewed = False
            self._redelivery.deliver(to_all=True)
        elif self._are_connected(time_s, types):
            uris = self._connections.uris
            self._is_renewed = not is_needed and any(
                self._uris.get(node) != uri for node, uri in uris.items())
            self._uris = {**self._uris, **uris}
            self._redelivery.deliver()

    def _are_connected(self, time_s: float, types: Mapping[str, str]) -> bool:
        """Return whether the nodes get all that they subscribe to, and can answer; report."""
        try:
            missing = self._connections.missing(types)
        except OSError as error:
            missing = ['the master, which does not answer: ' + one_line(error)]
        if missing:
            self._report(time_s, '; '.join(missing))
        return not missing
