"""Tells when simulated time has to wait for the subscribers, so that they lose no messages."""
import contextlib
import os
import time
from typing import Iterable, Set

import rospy

from img_recog.ros.master.local_subscribers import LocalSubscribers
from img_recog.ros.transport import subscribers

_PERIOD_S = 0.03        # of simulated time, between two looks: about that of a camera
_PATIENCE_S = 5.0       # of wall time


class SubscribersAtWork:
    """Finds the nodes on this computer that have not done yet what they subscribe to.

    A subscriber in C++ takes each message from its socket at once, into a queue that drops the
    oldest; only its threads show that it is behind. One in Python leaves messages in its socket
    while its callback runs, also while that sleeps. So a node is done when none of its threads
    runs or wants to, and nothing that was sent to it is unread.
    """

    def __init__(self) -> None:
        """Start to look for the nodes."""
        self._nodes = LocalSubscribers()
        self._looked_s, self._since_s = 0.0, 0.0
        self._awaited: Set[str] = set()
        self._given_up: Set[str] = set()

    def must_be_awaited(self, time_s: float) -> bool:
        """Return whether time must stand at `time_s`; for the loop, which asks again soon.

        A node that works for 5 s of wall time on end is not awaited any more, until it rests.
        """
        if not self._awaited:
            if self._looked_s <= time_s < self._looked_s + _PERIOD_S:
                return False
            self._looked_s, self._since_s = time_s, time.monotonic()
            self._awaited = set(self._nodes.pids)
        at_work = self._at_work(self._awaited | self._given_up)
        self._given_up &= at_work
        self._awaited = at_work - self._given_up
        if self._awaited and time.monotonic() > self._since_s + _PATIENCE_S:
            rospy.logwarn('%s: at work for more than %g s: simulated time goes on, and waits for '
                          'it again after it has rested', ', '.join(sorted(self._awaited)),
                          _PATIENCE_S)
            self._given_up |= self._awaited
            self._awaited = set()
        return bool(self._awaited)

    def _at_work(self, names: Iterable[str]) -> Set[str]:
        pids, unread = self._nodes.pids, subscribers.unread()
        return {name for name in names if name in unread or _is_running(pids.get(name, 0))}


def _is_running(pid: int) -> bool:
    """Return whether a thread of a process runs, or would if there were a processor for it."""
    folder = '/proc/{}/task/'.format(pid)
    with contextlib.suppress(OSError):      # it has ended
        for thread in os.listdir(folder):
            with contextlib.suppress(OSError), open(folder + thread + '/stat', 'rb') as file:
                # NUMBER (NAME) STATE ...; a name may have parentheses
                if file.read(64).rpartition(b') ')[2][:1] in (b'R', b'D'):
                    return True
    return False
