"""Publish the log lines of a node on /rosout synchronously."""
import logging
import struct
from typing import Callable, Optional, Set

import rospy
from rosgraph_msgs.msg import Log
from rospy.impl import registration, rosout

from img_recog.errors import one_line
from img_recog.ros import parameters
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.switch import is_plain

_LEVELS = {logging.DEBUG: Log.DEBUG, logging.INFO: Log.INFO, logging.WARNING: Log.WARN,
           logging.ERROR: Log.ERROR, logging.CRITICAL: Log.FATAL}
_HEADER, _LENGTH = struct.Struct('<IIII'), struct.Struct('<I')


def init_node(name: str, **options) -> None:
    """Call rospy.init_node, and replace rospy's handler for /rosout.

    For each line, rospy's handler gets a parameter from the master and passes a message to a
    thread.
    """
    if not is_plain('rosout'):
        rosout.Publisher = _publisher
        rosout.RosOutHandler = RosoutHandler
    rospy.init_node(name, **options)


def _publisher(name: str, data_class: type, latch: bool, queue_size: int) -> DirectPublisher:
    return DirectPublisher(name, data_class, latch)


class LineTopic:
    """Publishes lines of one place in the code on /rosout, without LogRecords."""

    def __init__(self, handler: 'RosoutHandler', level: int, file: str, function: str, line: int):
        """Publish by a handler.

        level: of logging; file, function, line: where the place is.
        """
        self._handler = handler
        self._msg = _Line(level=_LEVELS[level], name=rospy.get_name(), file=file,
                          function=function, line=line)

    def write(self, text: str) -> None:
        """Publish a line; errors are handled like those of the handler."""
        self._handler.publish(lambda: self._msg.fill(text, self._handler.topics()))


class _Line(Log):
    """A Log of which mostly only the header and the text change, serialized quickly."""

    def __init__(self, *args, **kwds):
        super().__init__(*args, **kwds)
        self._before = struct.pack('<b', self.level) + _string(self.name)
        self._place = _string(self.file) + _string(self.function) + _LENGTH.pack(self.line)
        self._names: Set[str] = set()
        self._after = self._place + _LENGTH.pack(0)

    def fill(self, text: str, topics: Set[str]) -> '_Line':
        """Set what may change except for the header; return the message."""
        self.msg = text
        if topics != self._names:
            # a copy: other threads add topics
            self._names = set(topics)
            self.topics = list(self._names)
            self._after = self._place + _LENGTH.pack(len(self.topics)) + b''.join(
                map(_string, self.topics))
        return self

    def serialize(self, buff):
        """Write the message to a buffer."""
        header = self.header
        buff.write(_HEADER.pack(header.seq, header.stamp.secs, header.stamp.nsecs, 0)
                   + self._before + _string(self.msg) + self._after)


def _string(text: str) -> bytes:
    data = text.encode()
    return _LENGTH.pack(len(data)) + data


class RosoutHandler(logging.Handler):
    """Publishes records as rosgraph_msgs/Log. logging.Handler locks, so threads may share it.

    Like rospy, swallow every error: logging must never break the caller.
    """

    def __init__(self):
        super().__init__()
        self._is_publishing = False
        self._names_topics: Optional[bool] = None

    def topics(self) -> Set[str]:
        """Return the topics of the node, if messages contain them."""
        if self._names_topics is None:
            self._names_topics = parameters.log_topics_are_wanted()
        return registration.get_topic_manager().get_topics() if self._names_topics else set()

    def emit(self, record: logging.LogRecord) -> None:
        self._publish(lambda: self._to_msg(record))

    def publish(self, to_msg: Callable[[], Log]) -> None:
        """Publish a message like one of a record."""
        self.acquire()
        try:
            self._publish(to_msg)
        finally:
            self.release()

    def _publish(self, to_msg: Callable[[], Log]) -> None:
        if rosout._rosout_pub is None or self._is_publishing:
            return
        self._is_publishing = True      # lines that are logged meanwhile would end up here again
        try:
            msg = to_msg()
            msg.header.stamp = rospy.Time.now()
            rosout._rosout_pub.publish(msg)
        except rospy.ROSException:      # the topic is closed during shutdown
            pass
        except Exception as error:
            logging.getLogger('rospy.rosout').warning('a line does not reach /rosout: %s',
                                                      one_line(error))
        finally:
            self._is_publishing = False

    def _to_msg(self, record: logging.LogRecord) -> Log:
        return Log(level=_LEVELS[record.levelno], name=rospy.get_name(), msg=self.format(record),
                   topics=list(self.topics()), file=record.filename, line=record.lineno,
                   function=record.funcName)
