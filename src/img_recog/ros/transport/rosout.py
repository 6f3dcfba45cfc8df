"""Publish the log lines of a node on /rosout synchronously."""
import logging
from typing import Optional

import rospy
from rosgraph_msgs.msg import Log
from rospy.impl import registration, rosout

from img_recog.errors import one_line
from img_recog.ros import parameters
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.switch import is_plain

_LEVELS = {logging.DEBUG: Log.DEBUG, logging.INFO: Log.INFO, logging.WARNING: Log.WARN,
           logging.ERROR: Log.ERROR, logging.CRITICAL: Log.FATAL}


def init_node(name: str, **options) -> None:
    """Call rospy.init_node, and replace rospy's handler for /rosout.

    For each line, rospy's handler gets a parameter from the master and passes a message to a
    thread.
    """
    if not is_plain('rosout'):
        rosout.Publisher = _publisher
        rosout.RosOutHandler = _RosoutHandler
    rospy.init_node(name, **options)


def _publisher(name: str, data_class: type, latch: bool, queue_size: int) -> DirectPublisher:
    return DirectPublisher(name, data_class, latch)


class _RosoutHandler(logging.Handler):
    """Publishes records as rosgraph_msgs/Log. logging.Handler locks, so threads may share it.

    Like rospy, swallow every error: logging must never break the caller.
    """

    def __init__(self):
        super().__init__()
        self._is_publishing = False
        self._names_topics: Optional[bool] = None

    def emit(self, record: logging.LogRecord) -> None:
        if rosout._rosout_pub is None or self._is_publishing:
            return
        self._is_publishing = True      # lines that are logged meanwhile would end up here again
        try:
            rosout._rosout_pub.publish(self._to_msg(record))
        except rospy.ROSException:      # the topic is closed during shutdown
            pass
        except Exception as error:
            logging.getLogger('rospy.rosout').warning('a line does not reach /rosout: %s',
                                                      one_line(error))
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
