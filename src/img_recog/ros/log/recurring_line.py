"""Log lines of one place in the code that come at the rate of a camera."""
import logging
import os
import sys
from typing import Optional, Tuple

from rosgraph.roslogging import RosStreamHandler

from img_recog.ros.log.log_handlers import LineFile
from img_recog.ros.transport.rosout import LineTopic, RosoutHandler

_LEVEL = logging.INFO


class RecurringLine:
    """Writes lines to the log file and to /rosout, like rospy.loginfo, but not to the terminal.

    Between two frames, the code and data of Python's logging leave the cache of the processor:
    then a line takes ten times as long as in a loop, a tenth of all that is done for a frame.
    Here it takes a third of that.
    """

    def __init__(self) -> None:
        self._logger, self._root = logging.getLogger('rosout'), logging.getLogger()
        self._outputs: Optional[Tuple[LineFile, LineTopic]] = None
        self._handlers: Tuple[list, list] = [], []      # that the outputs are of

    def write(self, text: str) -> bool:
        """Write a line; to be called from one place.

        Returns whether it is done. If not, because the log is not as usual, call rospy.loginfo.
        """
        if not self._logger.isEnabledFor(_LEVEL):
            return True
        if (self._logger.handlers, self._root.handlers) != self._handlers:
            self._handlers = list(self._logger.handlers), list(self._root.handlers)
            self._outputs = self._find_outputs()
        if self._outputs is None:
            return False
        file, topic = self._outputs
        file.write(text)
        topic.write(text)
        return True

    def _find_outputs(self) -> Optional[Tuple[LineFile, LineTopic]]:
        """Return what the handlers write to; None if one of them does more than usual."""
        topics = [each for each in self._logger.handlers if isinstance(each, RosoutHandler)]
        others = [each for each in self._logger.handlers
                  if not isinstance(each, (RosoutHandler, RosStreamHandler))]
        handlers = self._root.handlers
        if (others or len(topics) != 1 or len(handlers) != 1 or not self._logger.propagate
                or max(handlers[0].level, topics[0].level) > _LEVEL):
            return None
        file = LineFile.of(handlers[0], self._logger.name, logging.getLevelName(_LEVEL))
        if file is None:
            return None
        caller = sys._getframe(2)
        code, owner = caller.f_code, caller.f_locals.get('self')
        # as rosgraph's logger names it
        function = (code.co_name if owner is None
                    else '{}.{}'.format(type(owner).__name__, code.co_name))
        return file, LineTopic(topics[0], _LEVEL, os.path.basename(code.co_filename), function,
                               caller.f_lineno)
