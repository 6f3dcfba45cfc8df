"""What a node logs, sent to /rosout at once."""
import itertools
import logging
import sys
import threading
import time
from logging.handlers import RotatingFileHandler
from types import CodeType
from typing import Callable

import rospy
from rosgraph_msgs.msg import Log
from rospy.impl import registration, rosout

from img_recog.nodes import parameters
from img_recog.nodes.prompt_publisher import PromptPublisher

_LOGGER = logging.getLogger('rosout')
_LINES_A_LOOK = 100
_LEVELS = {logging.DEBUG: Log.DEBUG, logging.INFO: Log.INFO, logging.WARNING: Log.WARN,
           logging.ERROR: Log.ERROR, logging.CRITICAL: Log.FATAL}


def init_node(name: str, **options) -> None:
    """Call rospy.init_node, with what is here in place of its own.

    For each line, rospy asks the master for a parameter and hands a message to a thread, and its
    log file is looked up twice: with a line for each image, that costs more than to recognize
    what is in the image.
    """
    rosout.Publisher = _publisher
    rosout.RosOutHandler = _RosoutHandler
    rospy.init_node(name, **options)
    for handler in logging.getLogger().handlers:
        if isinstance(handler, RotatingFileHandler):
            handler.shouldRollover = seldom(handler.shouldRollover)


def info(text: str) -> None:
    """Log as rospy.loginfo does, in half the time: rospy walks the stack twice for the place."""
    if _LOGGER.isEnabledFor(logging.INFO):
        caller = sys._getframe(1)
        _LOGGER.handle(_records.of(text, caller.f_code, caller.f_lineno))


class _Records:
    """Makes records at INFO; what is the same from one to the next is found out once."""

    def __init__(self):
        self._place, self._first = None, None

    def of(self, text: str, code: CodeType, line: int) -> logging.LogRecord:
        place = code, line, threading.get_ident()
        if place != self._place:
            self._place, self._first = place, _LOGGER.makeRecord(
                _LOGGER.name, logging.INFO, code.co_filename, line, text, (), None, code.co_name)
            return self._first
        record = logging.LogRecord.__new__(logging.LogRecord)
        record.__dict__.update(self._first.__dict__)
        record.msg, record.created = text, time.time()
        record.msecs = record.created % 1 * 1000
        record.relativeCreated += (record.created - self._first.created) * 1000
        return record


_records = _Records()


def seldom(should_rollover: Callable) -> Callable:
    """Return a should_rollover that looks at the size of the file now and then only."""
    lines = itertools.count()
    return lambda record: next(lines) % _LINES_A_LOOK == 0 and should_rollover(record)


def _publisher(name: str, data_class: type, latch: bool, queue_size: int) -> PromptPublisher:
    return PromptPublisher(name, data_class, latch)


class _RosoutHandler(logging.Handler):
    """Publishes records as rosgraph_msgs/Log; its lock keeps threads apart."""

    def __init__(self):
        super().__init__()
        self._is_publishing, self._names_topics = False, None
        self._msg = Log()           # publish has sent it before the next is needed

    def emit(self, record: logging.LogRecord) -> None:
        if rosout._rosout_pub is None or self._is_publishing:
            return
        self._is_publishing = True      # what is logged on the way would come back here
        try:
            rosout._rosout_pub.publish(self._to_msg(record))
        except rospy.ROSException:      # the topic is closed while the node ends
            pass
        finally:
            self._is_publishing = False

    def _to_msg(self, record: logging.LogRecord) -> Log:
        if self._names_topics is None:
            self._names_topics = parameters.log_topics_are_wanted()
        msg = self._msg
        msg.header.stamp = rospy.Time.now()
        msg.level, msg.name = _LEVELS[record.levelno], rospy.get_name()
        msg.msg = self.format(record)
        msg.file, msg.line, msg.function = record.filename, record.lineno, record.funcName
        if self._names_topics:
            msg.topics = registration.get_topic_manager().get_topics()
        return msg
