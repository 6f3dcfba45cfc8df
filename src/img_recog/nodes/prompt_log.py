"""What a node logs, sent to /rosout at once."""
import logging
import sys

import rospy
from rosgraph_msgs.msg import Log
from rospy.impl import registration, rosout

from img_recog.nodes import parameters
from img_recog.nodes.prompt_publisher import PromptPublisher

_LEVELS = {logging.DEBUG: Log.DEBUG, logging.INFO: Log.INFO, logging.WARNING: Log.WARN,
           logging.ERROR: Log.ERROR, logging.CRITICAL: Log.FATAL}


def install() -> None:
    """Have rospy.init_node use what is here; to be called before it.

    For each line, rospy asks the master for a parameter and hands a message to a thread: with a
    line for each image, that costs more than to recognize what is in the image.
    """
    rosout.Publisher = _publisher
    rosout.RosOutHandler = _RosoutHandler


def info(text: str) -> None:
    """Log as rospy.loginfo does, in half the time: rospy walks the stack twice for the place."""
    logger = logging.getLogger('rosout')
    if logger.isEnabledFor(logging.INFO):
        caller = sys._getframe(1)
        logger.handle(logger.makeRecord(
            logger.name, logging.INFO, caller.f_code.co_filename, caller.f_lineno, text, (), None,
            caller.f_code.co_name))


def _publisher(name: str, data_class: type, latch: bool, queue_size: int) -> PromptPublisher:
    return PromptPublisher(name, data_class, latch)


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
