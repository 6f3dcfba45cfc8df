"""Collects the messages of topics, calls services, and runs the tests, for the rostests."""
import re

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Log
from std_srvs.srv import Empty

from img_recog_helpers import statuses
from img_recog_helpers.waiting import DEADLINE_S, wait_for


class Recorder:
    """Collects the messages of a topic that `accept` returns True for."""

    def __init__(self, topic, message_type, accept=lambda msg: True):
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


class AreaLines(Recorder):
    """Collects the lines in which the recognition logs its areas. node: by default any."""

    def __init__(self, node=''):
        super().__init__('/rosout', Log, lambda msg: msg.msg.startswith('blue=') and (
            not node or msg.name == node))

    def areas(self):
        """Return the areas in each line."""
        return [areas(msg) for msg in list(self.messages)]


def areas(msg):
    """Return the areas in pixels in a line of the log."""
    return tuple(int(part.split('=')[1]) for part in msg.msg.split(', '))


class Diagnostics(Recorder):
    """Collects the messages on /diagnostics."""

    def __init__(self):
        super().__init__('/diagnostics', DiagnosticArray)

    def values(self, name, first=0):
        """Return the values of a status in each message; the first one of a node has none."""
        found = [statuses.values(status) for msg in self.messages[first:]
                 for status in msg.status if status.name == name]
        return [values for values in found if values]

    def wait_values(self, name, accept=lambda values: True, is_new=False):
        """Return the first values of a status that are accepted. is_new: sent from now on."""
        first = len(self.messages) if is_new else 0
        return wait_for(lambda: next(filter(accept, self.values(name, first)), None),
                        lambda: '{} in {}'.format(name, self.messages[-2:]))


def call(name, kind=Empty, *request):
    """Wait for a service, and return its response."""
    rospy.wait_for_service(name)
    return rospy.ServiceProxy(name, kind)(*request)


def main(test_class):
    """Run the tests of a class in a node with its name: SlowTest in slow_test."""
    name = re.sub('(?<=[a-z])(?=[A-Z])', '_', test_class.__name__).lower()
    rospy.init_node(name)
    rostest.rosrun('img_recog', name[:-len('_test')], test_class)
