"""From a script to a running node and back to an exit code."""
import argparse
import contextlib
import logging
import os
import queue
import sys
import threading
import traceback
import xmlrpc.client
from types import MappingProxyType
from typing import Any, Callable, Iterator, Mapping, Optional, Sequence, Type

import rosgraph
import rospy

from img_recog.errors import UserError, one_line, shortened
from img_recog.processes import signals
from img_recog.ros import log_handlers, master_watch
from img_recog.ros.transport import own_time, rosout
from img_recog.settings import ParameterError, SettingError, Settings, allowed_text, setting_fields

# by the namespace of their parameters, such as '~'
SettingsClasses = Mapping[str, Sequence[Type[Settings]]]
EXIT_UNEXPECTED = 70        # EX_SOFTWARE of sysexits.h
# Only where it is set: by scripts/respawn.py, or for one of several robots. It is decided by them
# whether to start the node again
SUPERVISED = 'IMG_RECOG_RESPAWN'
EXIT_NO_MASTER, EXIT_REPLACED, EXIT_SHUT_DOWN, EXIT_REFUSED = 75, 76, 77, 78

END_LIMIT_S = 4.0           # of a node: rospy waits for the master without limit, then too
_JOIN_TIMEOUT_S = 0.5
_WAITING_S = 10.0           # after which a node says what it waits for
_REASON_TIMEOUT_S = 5.0     # after the hooks of the node, and unregistering


def parse(docstring: str, settings: SettingsClasses) -> None:
    """Print the help of a node and exit, if the command line has --help or -h.

    That is the docstring of its module, and a line for each parameter. Remappings, parameters and
    all else are for rospy and the node.
    """
    lines = [docstring.strip(), '',
             'Parameters, with defaults and allowed values (their meanings: doc/reference.md):']
    lines += ['  {}{}: {} ({})'.format(namespace, field.name, _shown(field.default),
                                       allowed_text(field))
              for namespace, classes in settings.items() for each in classes
              for field in setting_fields(each)]
    parser = argparse.ArgumentParser(
        usage='rosrun img_recog {} [_PARAMETER:=VALUE ...] [TOPIC:=OTHER_TOPIC ...]'.format(
            os.path.basename(sys.argv[0])),
        description='\n'.join(lines).replace('%', '%%'), add_help=False, allow_abbrev=False,
        formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument('-h', '--help', action='help', help=argparse.SUPPRESS)
    parser.parse_known_args(rosgraph.myargv()[1:])


def _shown(default: Any) -> str:
    if default is None:
        return 'required'
    return str(default).lower() if isinstance(default, bool) else str(default) or 'empty'


def run(name: str, serve: Callable[[], None],
        settings: SettingsClasses = MappingProxyType({}),
        source_of_time: bool = False, end_limit_s: Optional[float] = None) -> int:
    """Start the node `name`, call `serve` until it returns, and return the exit code.

    settings: the classes of its parameters, for --help: that prints them and the docstring of the
    module of `serve`, and starts nothing.
    source_of_time: whether it publishes /clock itself; it then calls own_time.set_time too.
    end_limit_s: time in which `serve` and rospy have to end after a shutdown, default END_LIMIT_S.

    An error that a user can fix ends the node with one line at FATAL and code 1; an unexpected
    exception is printed and is EXIT_UNEXPECTED; a shutdown is code 0. SIGINT, SIGTERM and SIGHUP
    (a terminal that is closed) shut it down; `serve` still runs while the hooks of `on_shutdown`
    do.
    """
    parse(sys.modules[serve.__module__].__doc__ or '', settings)
    log_handlers.use_safe_records()
    log_handlers.install()
    # rospy's own handler shuts down inside the interrupted call; if that is a publish in the
    # main thread, both wait for the same lock for ever
    try:
        _check_command_line()
        rosout.init_node(name, disable_signals=True,
                         disable_rostime=source_of_time and not own_time.follows_clock_topic())
    except UserError as error:      # there is no log yet
        sys.stderr.write('[FATAL] {}: {}\n'.format(name, one_line(error)))
        return 1
    code = EXIT_SHUT_DOWN if SUPERVISED in os.environ else 0
    limit = threading.Timer(end_limit_s or END_LIMIT_S, lambda: leave_blocked_threads(code))
    limit.daemon = True
    on_shutdown(limit.start)
    master_watch.start(on_shutdown)
    if not (source_of_time or rospy.rostime.is_wallclock()):
        warn_later(lambda: rospy.get_rostime().is_zero(), 'no time on /clock yet: start the '
                   'simulator, or run "rosparam set /use_sim_time false"')
    reasons: 'queue.Queue[str]' = queue.Queue()
    rospy.core.add_preshutdown_hook(reasons.put)
    signals.act_at_once(_shut_down)
    code = _run(serve)
    if code:
        rospy.signal_shutdown('exit code {}'.format(code))
    if code == 0 and SUPERVISED in os.environ and rospy.core.is_shutdown_requested():
        code = _shutdown_code(reasons)
    return code


def _check_command_line() -> None:
    """Raise ParameterError for a parameter that rospy cannot send to the master."""
    try:
        given = rospy.client.load_command_line_node_params(sys.argv)
    except rospy.exceptions.ROSInitException as error:      # no YAML
        raise ParameterError(one_line(error))
    for parameter, value in given.items():
        try:
            xmlrpc.client.dumps((value,))
        except (OverflowError, TypeError):
            raise ParameterError(
                'parameter ~{}: got {}, allowed are true, false, texts, numbers, and lists of '
                'them; integers have at most 32 bits'.format(parameter, shortened(repr(value))))


def _shutdown_code(reasons: 'queue.Queue[str]') -> int:
    """Wait for the reason of a shutdown that has begun; return the exit code for it."""
    with contextlib.suppress(queue.Empty):
        # rosmaster's words when another node of the same name registers
        if 'registered with same name' in reasons.get(timeout=_REASON_TIMEOUT_S):
            return EXIT_REPLACED
    return EXIT_SHUT_DOWN


def _run(serve: Callable[[], None]) -> int:
    try:
        serve()
    except ConnectionRefusedError:
        rospy.logfatal('no master answers at %s: start roscore or roslaunch first, or set '
                       'ROS_MASTER_URI', shortened(os.environ.get('ROS_MASTER_URI', '')))
        return EXIT_NO_MASTER if SUPERVISED in os.environ else 1
    except UserError as error:
        rospy.logfatal('%s', one_line(error))
        is_refused = isinstance(error, (ParameterError, SettingError))
        return EXIT_REFUSED if is_refused and SUPERVISED in os.environ else 1
    except Exception as error:
        if is_of_shutdown(error):
            return 0
        traceback.print_exc()
        return EXIT_UNEXPECTED
    return 0


def is_of_shutdown(error: Exception) -> bool:
    """Return whether an error is that of a node which is being shut down.

    rospy closes topics while other threads publish, before is_shutdown returns True. Then its
    code raises a ROSException, or any other error where it uses what is closed already.
    """
    if not rospy.core.is_shutdown_requested():
        return False
    return isinstance(error, rospy.ROSException) or any(
        frame.f_globals.get('__name__', '').split('.')[0] == 'rospy'
        for frame, _ in traceback.walk_tb(error.__traceback__))


@contextlib.contextmanager
def until_shutdown() -> Iterator[None]:
    """End the `with` without an error that is of a shutdown: for threads that publish."""
    try:
        yield
    except Exception as error:
        if not is_of_shutdown(error):
            raise


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


def warn_later(is_waiting: Callable[[], bool], line: str) -> None:
    """Log a warning once, if the node still waits for something when it has run for a while."""
    def warn() -> None:
        if is_waiting() and not rospy.core.is_shutdown_requested():
            rospy.logwarn('%s', line)
    timer = threading.Timer(_WAITING_S, warn)
    timer.daemon = True
    timer.start()


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


def _shut_down(number: int) -> None:
    # the process waits for it at its end, unlike for the thread that calls this
    threading.Thread(target=rospy.signal_shutdown, args=('signal {}'.format(number),),
                     daemon=False).start()
