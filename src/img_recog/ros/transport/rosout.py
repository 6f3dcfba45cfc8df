"""Logging at the rate of the frames: lines to /rosout and to the log file of a node."""
import itertools
import logging
import sys
import threading
import time
from logging.handlers import RotatingFileHandler
from types import FrameType
from typing import Callable

import rospy
from rosgraph_msgs.msg import Log
from rospy.impl import registration, rosout

from img_recog.ros import parameters
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.switch import is_plain

_LOGGER = logging.getLogger('rosout')
_ROLLOVER_CHECK_LINES = 100
_LEVELS = {logging.DEBUG: Log.DEBUG, logging.INFO: Log.INFO, logging.WARNING: Log.WARN,
           logging.ERROR: Log.ERROR, logging.CRITICAL: Log.FATAL}


def init_node(name: str, **options) -> None:
    """Call rospy.init_node, with our handler for /rosout in place of its own.

    For each line, rospy asks the master for a parameter and hands a message to a thread, and its
    log file is looked up twice: with a line for each image, that costs more than to recognize
    what is in the image.
    """
    if not is_plain('rosout'):
        rosout.Publisher = _publisher
        rosout.RosOutHandler = _RosoutHandler
    rospy.init_node(name, **options)
    for handler in logging.getLogger().handlers:
        if isinstance(handler, RotatingFileHandler) and not is_plain('log_file'):
            handler.shouldRollover = seldom(handler.shouldRollover)


def _info(text: str) -> None:
    """Log like rospy.loginfo, in half the time: rospy walks the stack twice for the place."""
    if _LOGGER.isEnabledFor(logging.INFO):
        caller = sys._getframe(1)
        _LOGGER.handle(_records.of(text, caller))


info = rospy.loginfo if is_plain('log_call') else _info


class _Records:
    """Makes records at INFO; what is the same from one to the next is found out once."""

    def __init__(self):
        self._place, self._first = None, None

    def of(self, text: str, caller: FrameType) -> logging.LogRecord:
        place = caller.f_code, caller.f_lineno, threading.get_ident()
        if place != self._place:
            self._place, self._first = place, _LOGGER.makeRecord(
                _LOGGER.name, logging.INFO, caller.f_code.co_filename, caller.f_lineno, text, (),
                None, _function(caller))
            return self._first
        record = logging.LogRecord.__new__(logging.LogRecord)
        record.__dict__.update(self._first.__dict__)
        record.msg, record.created = text, time.time()
        record.msecs = record.created % 1 * 1000
        record.relativeCreated += (record.created - self._first.created) * 1000
        return record


_records = _Records()


def _function(frame: FrameType) -> str:
    """Return what rospy calls a function: with the class of its self, if it has one."""
    name, local = frame.f_code.co_name, frame.f_locals
    return '{}.{}'.format(type(local['self']).__name__, name) if 'self' in local else name


def seldom(should_rollover: Callable) -> Callable:
    """Return a should_rollover that looks at the size of the file now and then only."""
    lines = itertools.count()
    return lambda record: next(lines) % _ROLLOVER_CHECK_LINES == 0 and should_rollover(record)


def _publisher(name: str, data_class: type, latch: bool, queue_size: int) -> DirectPublisher:
    return DirectPublisher(name, data_class, latch)


class _RosoutHandler(logging.Handler):
    """Publishes records as rosgraph_msgs/Log; its lock keeps threads apart."""

    def __init__(self):
        super().__init__()
        self._is_publishing, self._names_topics = False, None

    def emit(self, record: logging.LogRecord) -> None:
        if rosout._rosout_pub is None or self._is_publishing:
            return
        self._is_publishing = True      # what is logged on the way would come back here
        try:
            rosout._rosout_pub.publish(self._to_msg(record))
        except rospy.ROSException:      # the topic is closed while the node ends
            pass
        except Exception as error:      # of any kind, as rospy has it: whoever logs goes on
            logging.getLogger('rospy.rosout').warning('a line does not reach /rosout: %s', error)
        finally:
            self._is_publishing = False

    def _to_msg(self, record: logging.LogRecord) -> Log:
        if self._names_topics is None:
            self._names_topics = parameters.log_topics_are_wanted()
        topics = registration.get_topic_manager().get_topics() if self._names_topics else []
        msg = Log(level=_LEVELS[record.levelno], name=rospy.get_name(), msg=self.format(record),
                  topics=topics, file=record.filename, line=record.lineno,
                  function=record.funcName)
        msg.header.stamp = rospy.Time.now()
        return msg
