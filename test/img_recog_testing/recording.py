"""Collects the messages of a topic, for the rostests."""
import functools

import rospy

from img_recog.ros import lifecycle
from img_recog.ros.master import master_watch
from img_recog_testing.waiting import DEADLINE_S, wait_for


@functools.lru_cache(maxsize=None)      # once
def _keep_connected():
    """Connect subscribers of this process again to publishers that they are not connected to.

    rospy tries only once: a subscriber that was made while a publisher registered may miss it for
    ever, on a busy machine.
    """
    master_watch.start(lifecycle.on_shutdown)


class Recorder:
    """Collects the messages of a topic that `accept` returns True for."""

    def __init__(self, topic, message_type, accept=lambda msg: True):
        _keep_connected()
        self.messages = []
        self._topic = topic
        self._accept = accept
        self._subscriber = rospy.Subscriber(topic, message_type, self._store, queue_size=1000,
                                            buff_size=1 << 26, tcp_nodelay=True)

    def _store(self, msg):
        if self._accept(msg):
            self.messages.append(msg)

    def get_num_connections(self):
        """Return the number of publishers."""
        return self._subscriber.get_num_connections()

    def wait_connected(self, *nodes):
        """Wait until nodes of these names are connected: what they sent before is lost."""
        wait_for(lambda: {each.callerid_pub for each in list(self._subscriber.impl.connections)}
                 >= set(nodes), '{} of {}'.format(self._topic, ', '.join(nodes)))

    def close(self):
        """Unsubscribe."""
        self._subscriber.unregister()

    def wait(self, count=1, deadline_s=DEADLINE_S):
        """Wait until there are `count` more messages than now; return all."""
        goal = len(self.messages) + count
        wait_for(lambda: len(self.messages) >= goal,
                 '{} messages on {}'.format(count, self._topic), deadline_s)
        return self.messages


def from_node(name):
    """Return a filter for messages from the node of this name."""
    return lambda msg: msg._connection_header['callerid'] == name
