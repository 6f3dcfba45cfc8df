"""The log lines of a node on /rosout, and lines that come at the rate of a camera."""
import logging
import os
import sys
import time
from logging.handlers import RotatingFileHandler
from types import FrameType
from typing import Callable, List, Optional, Tuple

import rospy
from rosgraph.roslogging import RosStreamHandler
from rosgraph_msgs.msg import Log
from rospy.impl import registration, rosout

from img_recog.errors import one_line
from img_recog.ros import parameters
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.switch import is_plain

_LEVELS = {logging.DEBUG: Log.DEBUG, logging.INFO: Log.INFO, logging.WARNING: Log.WARN,
           logging.ERROR: Log.ERROR, logging.CRITICAL: Log.FATAL}
_FORMAT = '[%(name)s][%(levelname)s] %(asctime)s: %(message)s'      # rosgraph's, of a file
_TIME_FORMAT = '%Y-%m-%d %H:%M:%S'
_HEAD = '[rosout][INFO] '
_CHECK_LINES = 100      # after so many lines, the size of the file is checked
_NO_RECORD = logging.makeLogRecord({})


def init_node(name: str, **options) -> None:
    """Call rospy.init_node, and replace rospy's handler for /rosout.

    For each line, rospy's handler gets a parameter from the master. With it, and without
    RecurringLine, a frame of color_extract takes 57 % (48 % to 91 %) more CPU time, 30 % viewed.
    """
    if not is_plain('rosout'):
        rosout.Publisher = _publisher
        rosout.RosOutHandler = RosoutHandler
    rospy.init_node(name, **options)


def _publisher(name: str, data_class: type, latch: bool, queue_size: int) -> DirectPublisher:
    """Return the publisher of /rosout; with rospy's, a frame takes 8 % (6 % to 20 %) more."""
    return DirectPublisher(name, data_class, latch)


class RosoutHandler(logging.Handler):
    """Publishes records as rosgraph_msgs/Log.

    Like rospy, swallow every error: logging must never break the caller.
    """

    def __init__(self):
        super().__init__()
        self._is_publishing = False
        self._names_topics: Optional[bool] = None

    def emit(self, record: logging.LogRecord) -> None:
        self.publish(lambda: Log(
            level=_LEVELS[record.levelno], name=rospy.get_name(), msg=self.format(record),
            file=record.filename, line=record.lineno, function=record.funcName))

    def publish(self, message: Callable[[], Log]) -> None:
        """Publish a message, whose stamp and topics are set here."""
        self.acquire()      # again, if a record has come by `handle`
        try:
            if rosout._rosout_pub is not None and not self._is_publishing:
                self._publish(message)
        finally:
            self.release()

    def _publish(self, message: Callable[[], Log]) -> None:
        self._is_publishing = True      # lines that are logged meanwhile would end up here again
        try:
            msg = message()
            msg.header.stamp, msg.topics = rospy.Time.now(), self._topics()
            rosout._rosout_pub.publish(msg)
        except rospy.ROSException:      # the topic is closed during shutdown
            pass
        except Exception as error:
            logging.getLogger('rospy.rosout').warning('a line does not reach /rosout: %s',
                                                      one_line(error))
        finally:
            self._is_publishing = False

    def _topics(self) -> List[str]:
        """Return the topics of the node, if messages contain them."""
        if self._names_topics is None:
            self._names_topics = parameters.log_topics_are_wanted()
        return list(registration.get_topic_manager().get_topics()) if self._names_topics else []


class RecurringLine:
    """Writes lines to the log file and to /rosout, like rospy.loginfo, but not to the terminal.

    Between two frames, the code and data of Python's logging leave the cache of the processor:
    then a line takes ten times as long as in a loop. By rospy.loginfo, a frame of color_extract
    takes 19 % (7 % to 26 %) more CPU time, 5 % viewed.
    """

    def __init__(self) -> None:
        self._logger, self._root = logging.getLogger('rosout'), logging.getLogger()
        self._outputs: Optional[Tuple[RotatingFileHandler, RosoutHandler]] = None
        self._handlers: Tuple[list, list] = [], []      # that the outputs are of
        self._msg = Log(level=Log.INFO, name=rospy.get_name())
        self._second, self._second_text, self._lines = 0, '', 0

    def write(self, text: str) -> bool:
        """Write a line; to be called from one place.

        Returns whether it is done. If not, because the log is not as usual, call rospy.loginfo.
        """
        if not self._logger.isEnabledFor(logging.INFO):
            return True
        if (self._logger.handlers, self._root.handlers) != self._handlers:
            self._handlers = list(self._logger.handlers), list(self._root.handlers)
            self._outputs = self._find_outputs()
            self._set_place(sys._getframe(1))
        if self._outputs is None:
            return False
        file, topic = self._outputs
        self._write_to_file(file, text)
        self._msg.msg = text
        topic.publish(lambda: self._msg)
        return True

    def _find_outputs(self) -> Optional[Tuple[RotatingFileHandler, RosoutHandler]]:
        """Return what writes to file and topic; None if a handler does more than usual."""
        topics = [each for each in self._logger.handlers if isinstance(each, RosoutHandler)]
        others = [each for each in self._logger.handlers
                  if not isinstance(each, (RosoutHandler, RosStreamHandler))]
        if (others or len(topics) != 1 or len(self._root.handlers) != 1
                or not self._logger.propagate):
            return None
        file, topic = self._root.handlers[0], topics[0]
        formatter: Optional[logging.Formatter] = file.formatter
        # log_handlers.protect has replaced shouldRollover
        is_usual = (max(file.level, topic.level) <= logging.INFO and not file.filters
                    and 'shouldRollover' in vars(file) and type(formatter) is logging.Formatter
                    and formatter._fmt == _FORMAT and formatter.datefmt is None)
        return (file, topic) if is_usual and isinstance(file, RotatingFileHandler) else None

    def _set_place(self, caller: FrameType) -> None:
        """Name the place in the code as rosgraph's logger does."""
        code, owner = caller.f_code, caller.f_locals.get('self')
        self._msg.file, self._msg.line = os.path.basename(code.co_filename), caller.f_lineno
        self._msg.function = (code.co_name if owner is None
                              else '{}.{}'.format(type(owner).__name__, code.co_name))

    def _write_to_file(self, handler: RotatingFileHandler, text: str) -> None:
        """Write a line; an error is reported like those of the handler."""
        now_s = time.time()
        handler.acquire()
        try:
            # shouldRollover opens a file that could not be opened
            if ((handler.stream is None or self._lines % _CHECK_LINES == 0)
                    and handler.shouldRollover(_NO_RECORD)):
                handler.doRollover()
            self._lines += 1
            if int(now_s) != self._second:
                self._second = int(now_s)
                self._second_text = time.strftime(_TIME_FORMAT, time.localtime(now_s))
            handler.stream.write('{}{},{:03d}: {}\n'.format(
                _HEAD, self._second_text, int((now_s - self._second) * 1000), text))
            handler.flush()
        except Exception:
            handler.handleError(_NO_RECORD)
        finally:
            handler.release()
