"""The simulator, the user's nodes and the test in one ROS graph, from their start to their end."""
import atexit
import contextlib
import io
import logging
import os
import queue
import sys
import tempfile
import threading
import time
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple

import rosgraph
import rosmaster.master
import rosnode
import rospy
from rosgraph_msgs.msg import Clock
from std_srvs.srv import Trigger

from img_recog.errors import UserError, one_line
from img_recog.ros import timed_xmlrpc
from img_recog.ros.connections import Connections
from img_recog.ros.timed_xmlrpc import Master
from img_recog.testing.launching import Launch, LaunchFile, of_reasons
from img_recog.testing.topics import Topics

_NODE = 'simulation_test'
_TIMEOUT_S = 5.0        # of a call of the master
_KEPT = ('run_id', 'rosdistro', 'rosversion', 'roslaunch')
_session: Optional['Session'] = None
__tracebackhide__, __unittest = of_reasons, True
_SIMULATOR, _ROBOTS = '/gazebo', '/robots'
_STEP, _STEP_PERIOD, _RELOAD = '/gazebo/step', '/gazebo/step_period', '/robots/reload'
_CLOCK = '/clock'
_WAITS = 'simulation paused: waiting for'     # of the lines that say for whom
_POLL_PERIOD_S, _SETTLING_PERIOD_S, _SETTLING_S = 0.05, 0.001, 5.0      # of wall time
_MAX_STEP_S = 3600.0        # of ~step_period
_NO_CALL = -1
_active: List['Running'] = []


def get() -> 'Session':
    """Return the session of this process; the first call starts the master and the node."""
    global _session
    if _session is None:
        _session = Session()
    return _session


class Session:
    """A master and a node. uri: of the master, master: its calls.

    The master is in this process, on a free port of this computer, unless this process is a node
    already, or roslaunch or rostest has started it as one: then it is that which is given.
    """

    def __init__(self) -> None:
        """Start both. Raises UserError if a master that was given does not answer."""
        is_started = any(word.startswith('__name:=') for word in sys.argv)
        if not (is_started or rospy.core.is_initialized()):
            self._start_master()
        self.uri = rosgraph.get_master_uri()
        self.master = Master(self.uri, '/' + _NODE, _TIMEOUT_S)
        try:
            self.master.call('setParam', '/use_sim_time', True)
        except timed_xmlrpc.ERRORS:
            raise UserError('no master answers at {}'.format(self.uri), 'start the test by '
                            'rostest or pytest') from None
        if not rospy.core.is_initialized():
            # signals are for pytest and unittest
            rospy.init_node(_NODE, anonymous=not is_started, disable_signals=True)
        # pytest would show their lines for each failure; the master logs each node that has ended
        for name, level in (('rosmaster', logging.CRITICAL), ('roslaunch', logging.WARNING),
                            ('rospy', logging.WARNING)):
            logging.getLogger(name).setLevel(level)

    def _start_master(self) -> None:
        if not (os.environ.get('ROS_HOSTNAME') or os.environ.get('ROS_IP')):
            os.environ['ROS_HOSTNAME'] = 'localhost'
        master = rosmaster.master.Master(port=0)
        master.start()
        os.environ['ROS_MASTER_URI'] = master.uri
        atexit.register(rospy.signal_shutdown, 'the tests are over')

    def nodes(self) -> Dict[str, Optional[str]]:
        """Return the nodes that the master knows, with their addresses."""
        return {name: self.master.ask('lookupNode', name) for name in self.master.state().nodes}

    def forget(self, names: Iterable[str]) -> None:
        """Have the master forget those of the nodes that were killed: they do not answer."""
        gone = [name for name in names
                if not _answers(self.master.ask('lookupNode', name) or '')]
        with contextlib.redirect_stdout(io.StringIO()):     # a line for each node
            rosnode.cleanup_master_blacklist(rosgraph.Master('/' + _NODE), gone)

    def parameters(self) -> Dict[str, Any]:
        """Return all parameters, by the first part of their names."""
        return self.master.call('getParam', '/')

    def restore(self, before: Dict[str, Any]) -> None:
        """Have the parameters as they were, apart from those of roslaunch."""
        after = self.parameters()
        for name in set(before) | set(after):
            if name in _KEPT or before.get(name) == after.get(name):
                continue
            if name in after:       # setParam would leave what is in a namespace and was not
                self.master.call('deleteParam', '/' + name)
            if name in before:
                self.master.call('setParam', '/' + name, before[name])


def _answers(uri: str) -> bool:
    try:
        timed_xmlrpc.server(uri).getPid('/' + _NODE)
    except timed_xmlrpc.ERRORS:
        return False
    return True


class Wakeup:
    """What the main thread waits for; Ctrl-C ends the wait, and nothing stays locked.

    It is a Lock. A Condition is written in Python: Ctrl-C can leave it locked for ever. A
    SimpleQueue can wait too long after a signal, see LatestValue.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()       # released by `notify`
        self._lock.acquire()

    def notify(self) -> None:
        """End the wait, or the next one; for any other thread."""
        with contextlib.suppress(RuntimeError):         # it is released already
            self._lock.release()

    def wait(self, timeout_s: float) -> None:
        """Wait for a `notify`, at most for a time in s."""
        self._lock.acquire(timeout=timeout_s)


class InterruptibleCalls:
    """Calls a function in a thread; Ctrl-C in the main thread, which waits for it, ends the wait.
    """

    def __init__(self, function: Callable[[], Any]):
        """Start the thread. It ends with `end`, or with the process."""
        self._function = function
        self._numbers: 'queue.SimpleQueue[int]' = queue.SimpleQueue()      # of calls
        self._number = 0
        self._response: Tuple[int, Any] = 0, None       # or an error, with the number of its call
        self._responded = Wakeup()
        self._thread = threading.Thread(target=self._run, daemon=True)
        self._thread.start()

    def _run(self) -> None:
        for number in iter(self._numbers.get, _NO_CALL):
            try:
                self._response = number, self._function()
            except Exception as error:
                self._response = number, error
            self._responded.notify()

    def call(self, watch: Callable[[], None]) -> Any:
        """Return what the function returns, or the error that it raises.

        Args:
            watch: Function that is called while there is no response. It can raise an error.
        """
        self._number += 1
        self._numbers.put(self._number)
        self._responded.wait(_POLL_PERIOD_S)
        while self._response[0] != self._number:        # others are of calls that were given up
            watch()
            self._responded.wait(_POLL_PERIOD_S)
        return self._response[1]

    def end(self) -> None:
        """End the thread."""
        self._numbers.put(_NO_CALL)
        self._thread.join(_TIMEOUT_S)


class Running:
    """Starts all, lets time pass, and ends all. topics: what the test has subscribed to."""

    def __init__(self, files: Sequence[LaunchFile], wall_timeout_s: float):
        """Start roslaunch.

        wall_timeout_s: how long nothing may happen before it is an error, of wall time.
        Raises UserError for what the user gave.
        """
        if _active:
            raise UserError('another Simulation runs in this process', 'end it before: one uses '
                            'the names of the nodes of the other')
        self._wall_timeout_s = wall_timeout_s
        self._session = get()
        self._known = set(self._session.nodes())
        if _SIMULATOR in self._known:
            raise UserError('the master {} has a node {} already'.format(
                self._session.uri, _SIMULATOR), 'leave demo.launch out of the .test file: '
                'Simulation starts it')
        self._parameters = self._session.parameters()
        self._folder = tempfile.TemporaryDirectory(prefix='img_recog_')
        self.topics = Topics()
        # a call without a response ends with the simulator
        self._step = rospy.ServiceProxy(_STEP, Trigger, persistent=True)
        self._calls = InterruptibleCalls(self._step)
        self._arrived = Wakeup()        # by messages
        self._now_s, self._period_s = 0.0, 0.0
        # first: it is settled only where it has seen the beginning of a connection
        self.topics.subscribe(_CLOCK, Clock, self._take_time)
        try:
            self.launch = Launch(files, os.path.join(self._folder.name, 'simulation.launch'))
        except BaseException:
            self.topics.close()
            self._calls.end()
            self._folder.cleanup()
            raise
        _active.append(self)

    def wait_ready(self) -> None:
        """Wait until all nodes are there and connected. Raises AssertionError if that fails."""
        connections = Connections(self._session.uri, rospy.get_name())
        self._wait(lambda: '' if self.launch.is_complete else 'roslaunch to start all nodes')
        services = [_STEP] + ([_RELOAD] if _ROBOTS in self.launch.nodes else [])
        self._wait(lambda: ', '.join('the service ' + name for name in services
                                     if not self._session.master.ask('lookupService', name)))
        self._wait(lambda: '; '.join(connections.missing(self.topics.types,
                                                         self.launch.nodes)))

    def _take_time(self, msg: Clock) -> None:
        self._now_s = msg.clock.to_sec()
        self._arrived.notify()

    @property
    def time_s(self) -> float:
        """The simulated time in s."""
        return self._now_s

    def publishers(self, topic: str) -> List[str]:
        """Return the nodes that publish a topic."""
        return self._session.master.state().published.get(topic, [])

    def nodes(self) -> List[str]:
        """Return the names of the nodes that were started, also by others of them, in order."""
        return sorted(set(self._session.nodes()) - self._known)

    def types(self) -> Dict[str, str]:
        """Return the types of all topics that are published, by their names."""
        return dict(self._session.master.call('getPublishedTopics', ''))

    def reason_without(self, topic: str, data_class: Any) -> str:
        """Return why no message of a topic comes."""
        publishers = self.publishers(topic)
        if publishers:
            return '{} has sent none'.format(', '.join(publishers))
        return 'nobody publishes it; of its type there is {}'.format(', '.join(sorted(
            name for name, kind in self.types().items() if kind == data_class._type)) or 'none')

    def wait_connected(self) -> None:
        """Wait until what was subscribed to comes from those who publish it."""
        connections = Connections(self._session.uri, rospy.get_name())
        types = {name: kind for name, kind in self.topics.types.items() if self.publishers(name)}
        self._wait(lambda: '; '.join(connections.missing(types)))

    def _wait(self, missing: Callable[[], str]) -> None:
        """Wait until nothing is missing; the time starts again when that changes."""
        last, began_s = '', time.monotonic()
        while True:
            self.launch.check()
            try:
                found = missing()
            except timed_xmlrpc.ERRORS as error:
                found = 'the master, which does not answer: ' + one_line(error)
            if not found:
                return
            if found != last:
                last, began_s = found, time.monotonic()
            elif time.monotonic() > began_s + self._wall_timeout_s:
                raise AssertionError('after {:g} s on the clock it still waits for: {}\n{}'.format(
                    self._wall_timeout_s, found, self.launch.tail()))
            self._arrived.wait(_POLL_PERIOD_S)

    def step(self, seconds: float) -> None:
        """Let simulated time pass, and wait until what was sent in it has come."""
        if not seconds > 0:
            raise UserError('step: got {:g} s'.format(seconds), 'give a time above 0')
        left_s = seconds
        while left_s > 1e-9:
            self._step_once(min(left_s, _MAX_STEP_S))
            left_s -= _MAX_STEP_S
        self._settle()

    def _step_once(self, seconds: float) -> None:
        seconds = round(seconds, 9)
        if seconds != self._period_s:
            rospy.set_param(_STEP_PERIOD, seconds)
            self._period_s = seconds
        began_s, now_s = time.monotonic(), self._now_s

        def watch() -> None:
            nonlocal began_s, now_s
            self.launch.check()
            if now_s != self._now_s:
                began_s, now_s = time.monotonic(), self._now_s
            elif time.monotonic() > began_s + self._wall_timeout_s:
                raise AssertionError('simulated time has not passed for {:g} s on the clock: {}\n'
                                     '{}'.format(self._wall_timeout_s, self._standing(),
                                                 self.launch.tail()))
        response = self._calls.call(watch)
        if isinstance(response, (rospy.ServiceException, rospy.ROSException, OSError)):
            self.launch.check(is_end_near=True)
            raise AssertionError('the simulator does not answer: {}\n{}'.format(
                one_line(response), self.launch.tail()))
        if isinstance(response, Exception):
            raise response
        if not response.success:
            raise UserError('step: {}'.format(response.message))

    def _standing(self) -> str:
        line = self.launch.find(_WAITS)
        return line[line.index(_WAITS):] if line else 'it is {:.3f} s'.format(self._now_s)

    def _settle(self) -> None:
        end_s = time.monotonic() + _SETTLING_S
        while not self.topics.is_settled() and time.monotonic() < end_s:
            self._arrived.wait(_SETTLING_PERIOD_S)

    def wait_while_standing(self, condition: Callable[[], Any], timeout_s: float) -> None:
        """Wait for a condition in wall time. Raises AssertionError if a node dies."""
        end_s = time.monotonic() + timeout_s
        while not condition() and time.monotonic() < end_s:
            self.launch.check()
            self._arrived.wait(_POLL_PERIOD_S)

    def end(self) -> None:
        """End all nodes; the master forgets them and their parameters."""
        try:
            self.launch.end()
            self.topics.close()
            self._step.close()
            self._calls.end()
            self._session.forget(self.nodes())
            self._session.restore(self._parameters)
        finally:
            self._folder.cleanup()
            _active.remove(self)
