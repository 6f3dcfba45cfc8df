"""Logging to the terminal alone when the log file of a node cannot be written."""
import logging
import os
import sys
from typing import Mapping, Optional

import rospkg
from rosgraph import roslogging

from img_recog.errors import one_line, shortened
from img_recog.ros.log import log_handlers

_configure = roslogging.configure_logging


def install() -> None:
    """Let rospy.init_node continue without a log file, which would end it with a traceback."""
    roslogging.configure_logging = _configure_if_writable


def _configure_if_writable(logname: str, level: int = logging.INFO, filename: Optional[str] = None,
                           env: Optional[Mapping[str, str]] = None) -> Optional[str]:
    """Replaces rosgraph's function: return the name of the log file, None if there is none.

    It has the file made first. rosgraph would raise the error, or log nothing, not even to the
    terminal.
    """
    path = os.path.join(rospkg.get_log_dir(env=env), filename or logname)
    try:
        roslogging.makedirs_with_parent_perms(os.path.dirname(path))
        with open(path, 'a'):
            pass
    except OSError as error:
        sys.stderr.write('[WARN] there is no log file, only the terminal: cannot write {}: {}; '
                         'set ROS_HOME or ROS_LOG_DIR to a folder that can be written\n'.format(
                             shortened(path), one_line(error)))
        _log_to_terminal()
        return None
    configured = _configure(logname, level, filename, env)
    log_handlers.protect()      # before rospy's first line
    return configured


def _log_to_terminal() -> None:
    """Do what rosgraph's configuration does, without the file."""
    root, rosout = logging.getLogger(), logging.getLogger('rosout')
    root.setLevel(logging.INFO)
    root.addHandler(logging.NullHandler())
    rosout.setLevel(logging.INFO)
    rosout.addHandler(roslogging.RosStreamHandler())
