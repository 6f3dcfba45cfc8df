"""From a script to a running node and back to an exit code."""
import logging
import os
import signal
import sys
import threading
from typing import Callable

import genpy
import rospy

from img_recog.errors import UserError, one_line, shortened
from img_recog.ros import console, log_files, log_handlers, log_records
from img_recog.ros.transport import handshakes, own_time, rosout

_JOIN_TIMEOUT_S = 0.5


def run(name: str, serve: Callable[[], None], source_of_time: bool = False) -> int:
    """Start the node `name`, call `serve` until it returns, and return the exit code.

    source_of_time: whether it publishes /clock itself; it then calls `set_time` too.

    An error that a user can fix ends the node with one line at FATAL and code 1; a shutdown is
    code 0. SIGINT, SIGTERM and SIGHUP (a terminal that is closed) shut it down; `serve` still
    runs while the hooks of `on_shutdown` do.
    """
    log_records.install()
    log_files.install()
    # rospy's own handler shuts down inside the interrupted call; if that is a publish in the
    # main thread, both wait for the same lock for ever
    try:
        handshakes.install()
        rosout.init_node(name, disable_signals=True,
                         disable_rostime=source_of_time and not own_time.follows_clock_topic())
    except UserError as error:      # there is no log yet
        sys.stderr.write('[FATAL] {}: {}\n'.format(name, one_line(error)))
        return 1
    console.install_filter()
    log_handlers.protect()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        if signal.getsignal(number) != signal.SIG_IGN:      # as under nohup
            signal.signal(number, _shut_down)
    try:
        serve()
    except rospy.ROSException:
        # when a node is shut down from outside, its topics are closed while it publishes, before
        # is_shutdown returns True
        if not rospy.core.is_shutdown_requested():
            raise
    except ConnectionRefusedError:
        rospy.logfatal('no master answers at %s: start roscore or roslaunch first, or set '
                       'ROS_MASTER_URI', shortened(os.environ.get('ROS_MASTER_URI', '')))
        rospy.signal_shutdown('no master')
        return 1
    except UserError as error:
        rospy.logfatal('%s', one_line(error))
        rospy.signal_shutdown('cannot go on')
        return 1
    return 0


def on_shutdown(hook: Callable[[], None]) -> None:
    """Call `hook` once when the node is shut down, even if the shutdown has begun already.

    rospy.on_shutdown drops a hook that is added while others run: a node that is interrupted
    while it starts would not be notified.
    """
    first = threading.Lock()

    def call():
        if first.acquire(blocking=False):
            hook()
    rospy.on_shutdown(call)
    if rospy.core.is_shutdown_requested():
        call()


def leave_blocked_threads(code: int) -> None:
    """End the process with this exit code although a thread is blocked in a library.

    Python would end the thread when the library returns, inside C++ code, which aborts the
    process.
    """
    rospy.signal_shutdown('done')
    for thread in threading.enumerate():
        if not thread.daemon and thread is not threading.current_thread():
            thread.join(_JOIN_TIMEOUT_S)     # one of them may be unregistering with the master
    logging.shutdown()
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)


def set_time(now: genpy.Time) -> None:
    """Set this node's own time, where the node is the source of time."""
    own_time.set_time(now)


def _shut_down(number: int, _) -> None:
    threading.Thread(target=rospy.signal_shutdown, args=('signal {}'.format(number),)).start()
