"""The log lines of a node on /rosout, and lines that come at the rate of a camera."""
import contextlib
import io
import logging
import struct
import sys
import time
import xmlrpc.client
from types import FrameType
from typing import Collection, Optional

import rospy
from rosgraph_msgs.msg import Log
from rospy.impl import paramserver, registration, rosout

from img_recog.ros import parameters
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.switch import is_plain

_STAMP, _LENGTH = struct.Struct('<3I'), struct.Struct('<I')
_BEFORE_NAME = _STAMP.size + _LENGTH.size + 1       # header without a frame_id, level


def init_node(name: str, **options) -> None:
    """Call rospy.init_node, and have the lines on /rosout take less time.

    For each line, rospy asks the master for a parameter that is usually not set: with that, a
    frame of color_extract takes 39 % (32 % to 41 %) more CPU time, and twice as long. So it is
    read once.
    """
    if is_plain('rosout'):
        rospy.init_node(name, **options)
        return
    rosout.Publisher = _publisher
    rospy.init_node(name, **options)
    with contextlib.suppress(OSError, xmlrpc.client.Error):     # then it is asked for each line
        _keep(parameters.LOG_TOPICS_ARE_LEFT_OUT, parameters.log_topics_are_left_out())


def _keep(name: str, value: bool) -> None:
    """Let rospy have the value of a parameter without asking the master.

    If it were set in rospy's cache, that would answer for the namespace of the parameter, too:
    rospy.get_param('/') would return this parameter alone.
    """
    cache = paramserver.get_param_server_cache()
    in_cache = cache.get
    setattr(cache, 'get', lambda key: value if key == name else in_cache(key))


def _publisher(name: str, data_class: type, latch: bool, queue_size: int) -> DirectPublisher:
    """Return the publisher of /rosout.

    With rospy's, a frame takes 9 % (5 % to 18 %) more CPU time, 11 % (5 % to 19 %) viewed.
    """
    return DirectPublisher(name, data_class, latch)


class _Line(Log):
    """A message of which only time and text change: the rest is serialized once.

    Otherwise the names of the topics, one by one, take 3 % of a frame of color_extract.
    """

    def set_topics(self, topics: Collection[str]) -> None:
        """Set the topics; call it after a change of any other field, too."""
        self.topics, self.msg = topics, ''
        buffer = io.BytesIO()
        super().serialize(buffer)
        fields = buffer.getvalue()
        end = _BEFORE_NAME + _LENGTH.size + len(self.name.encode())
        self._before, self._behind = fields[_STAMP.size:end], fields[end + _LENGTH.size:]

    def serialize(self, buff: io.BytesIO) -> None:
        """Write the message to a buffer."""
        text, stamp = self.msg.encode(), self.header.stamp
        buff.write(b''.join((
            _STAMP.pack(self.header.seq, stamp.secs, stamp.nsecs), self._before,
            _LENGTH.pack(len(text)), text, self._behind)))


class RecurringLine:
    """Writes lines of one place to the log file, to /rosout, and maybe to the terminal.

    The time of a line is taken apart, because writing takes 0.2 ms, and sending alone most of
    that. So what comes after the line does not wait for it, and the line still has its time before
    that.

    Between two frames, the code and data of Python's logging leave the cache of the processor. So
    the record and the message are made once: with new ones each time, a frame of color_extract
    takes 10 % (8 % to 13 %) more CPU time, by rospy.loginfo 13 % (5 % to 20 %).
    """

    def __init__(self) -> None:
        self._logger = logging.getLogger('rosout')
        self._record: Optional[logging.LogRecord] = None
        self._msg = _Line(level=Log.INFO, name=rospy.get_name())
        self._names_topics = not parameters.log_topics_are_left_out()
        self.take_time()

    def take_time(self) -> None:
        """Give the next line the time of now."""
        self._time_s, self._msg.header.stamp = time.time(), rospy.Time.now()

    def write(self, text: str, on_terminal: bool = False) -> None:
        """Write a line with the time that was taken; to be called from one place in a method.

        Args:
            text: Text of the line.
            on_terminal: Whether to write it to the terminal, too.
        """
        if not self._logger.isEnabledFor(logging.INFO):
            return
        if self._record is None:
            self._record = self._record_of(sys._getframe(1))
        record, msg = self._record, self._msg
        record.msg, record.created = text, self._time_s
        record.msecs = int(1000 * (record.created % 1))
        handlers = list(logging.getLogger().handlers)
        if on_terminal:
            handlers += [each for each in self._logger.handlers
                         if not isinstance(each, rosout.RosOutHandler)]
        for handler in handlers:
            if record.levelno >= handler.level:
                handler.handle(record)
        topics = registration.get_topic_manager().get_topics()
        if self._names_topics and topics != msg.topics:
            msg.set_topics(topics)
        msg.msg = text
        with contextlib.suppress(rospy.ROSException):       # the topic is closed at the shutdown
            rosout._rosout_pub.publish(msg)

    def _record_of(self, place: FrameType) -> logging.LogRecord:
        """Return a record that names a place in the code as rosgraph's logger does."""
        function = '{}.{}'.format(type(place.f_locals['self']).__name__, place.f_code.co_name)
        record = self._logger.makeRecord(
            self._logger.name, logging.INFO, place.f_code.co_filename, place.f_lineno, '', (),
            None, function)
        self._msg.file, self._msg.line = record.filename, record.lineno
        self._msg.function = function
        self._msg.set_topics(())
        return record
