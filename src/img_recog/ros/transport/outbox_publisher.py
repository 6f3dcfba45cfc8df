"""What the publishers of small messages and of images have in common."""
import warnings
from typing import Optional

import rospy
from rospy.impl.tcpros_base import TCPROSTransport
from rospy.topics import _PublisherImpl

from img_recog.ros.transport.outbox import Outbox, Packet, send
from img_recog.ros.transport.redelivery import Redelivery
from img_recog.ros.transport.switch import is_plain


class OutboxPublisher:
    """Advertises a topic whose connections have an Outbox each; with plain rospy, a queue.

    They have it before rospy sends them the latched message.
    """

    def __init__(self, part: str, name: str, data_class: type, queue_size: int,
                 latch: bool = False, redelivery: Optional[Redelivery] = None):
        """Advertise the topic `name`.

        part, queue_size: with IMG_RECOG_PLAIN_ROSPY. latch: whether a new subscriber gets the
        last message. redelivery: sends the messages.
        """
        self._is_plain, self._redelivery = is_plain(part), redelivery
        if self._is_plain:
            self._publisher = rospy.Publisher(name, data_class, queue_size=queue_size,
                                              latch=latch or redelivery is not None)
            return
        with warnings.catch_warnings():
            warnings.simplefilter('ignore', SyntaxWarning)      # about the missing queue
            self._publisher = rospy.Publisher(name, data_class, latch=latch, queue_size=None)
        topic = self._publisher.impl
        with topic.c_lock:
            if 'add_connection' not in vars(topic):     # not advertised in another place
                self._add_connection = topic.add_connection
                topic.add_connection = self._connect
                for connection in topic.connections:
                    _give_outbox(connection)

    def get_num_connections(self) -> int:
        """Return the number of subscribers."""
        return self._publisher.get_num_connections()

    def unregister(self) -> None:
        """Stop to advertise; nothing can be published any more."""
        self._publisher.unregister()

    def _connect(self, connection: TCPROSTransport) -> bool:
        _give_outbox(connection)
        return self._add_connection(connection)

    def _send(self, packet: Packet, topic: _PublisherImpl) -> None:
        if self._redelivery is None:
            send(packet, topic.connections)
        else:
            self._redelivery.send(packet, topic)


def _give_outbox(connection: TCPROSTransport) -> None:
    connection.outbox = Outbox(connection)
    connection.write_data = connection.outbox.write_data
