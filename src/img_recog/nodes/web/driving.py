"""Drives the robot for a visitor of a page, in place of the nodes that drive it otherwise."""
import math
import threading
import time
from typing import Callable, List, Optional, Set, Tuple

import rospy
from std_srvs.srv import Trigger

from img_recog.conversions import twist_msgs
from img_recog.errors import one_line
from img_recog.ros import timed_xmlrpc
from img_recog.ros.log.throttle import ThrottledWarning
from img_recog.ros.master import master
from img_recog.ros.stopping_publisher import StoppingPublisher
from img_recog.teleoperation.profile import VelocityLimits

_PERIOD_S = 0.05
POLL_PERIOD_S = 1.0    # how often the threads check for the shutdown
HOLD_S = 0.3            # a page repeats its command; after this time without one, the robot stops
YIELD_PERIOD_S = 0.2
READ_PERIOD_S = 1.0    # of the nodes that can yield
_SERVICE = '/yield'
_STOPS = 3              # zeros that are sent after a release


class Speeds:
    """Who drives, how fast, and until when. Independent of ROS; for any thread."""

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now, self._lock = now, threading.Lock()
        self._owner: Optional[object] = None        # the last one that has not released
        self._refused: Set[object] = set()
        self._shares, self._until_s = (0.0, 0.0), 0.0

    def hold(self, owner: object, linear: float, angular: float) -> bool:
        """Set the shares of the highest speeds for HOLD_S; return False if that is refused.

        While another owner drives, all but a stop is refused; a stop takes over from it. Who was
        refused or lost the robot is refused until it has released: the robot must not obey it when
        the other one pauses, long after its key was pressed.
        """
        with self._lock:
            has_other = self._owner not in (None, owner)
            if (linear or angular) and (
                    owner in self._refused or has_other and self._is_driven()):
                self._refused.add(owner)
                return False
            if has_other:
                self._refused.add(self._owner)
            self._owner, self._shares = owner, (linear, angular)
            self._until_s = self._now() + HOLD_S
            return True

    def release(self, owner: object) -> None:
        """End what this owner holds."""
        with self._lock:
            self._refused.discard(owner)
            if self._owner is owner:
                self._owner = None

    def current(self) -> Optional[Tuple[float, float]]:
        """Return the shares, None if nobody drives."""
        with self._lock:
            return self._shares if self._is_driven() else None

    def _is_driven(self) -> bool:
        return self._owner is not None and self._now() < self._until_s


class Driving:
    """Publishes cmd_vel (geometry_msgs/Twist, 20 Hz) while somebody drives, and zeros at the end.

    Calls the service NODE/yield (std_srvs/Trigger) of each other publisher of cmd_vel that has it,
    so that this node publishes nothing meanwhile. settings: the highest speeds that are allowed;
    limits: those that are set.
    """

    def __init__(self, settings: VelocityLimits, topic: str):
        """Advertise `topic`, the full name of the robot's cmd_vel."""
        self.settings = settings
        self.limits = {name: getattr(settings, name)
                       for name in ('max_linear_velocity', 'max_angular_velocity')}
        self._speeds, self._driven = Speeds(), threading.Event()
        self._warn = ThrottledWarning()
        self._asked: Set[str] = set()       # services whose answer has not come yet
        # driven until the zeros of a release were sent, too
        self._topic, self._velocity = topic, StoppingPublisher(topic, self._driven.is_set)
        for target in (self._publish, self._hold_others):
            threading.Thread(target=target, daemon=True).start()

    def limit(self, name: str, value: float) -> None:
        """Set a highest speed: max_linear_velocity in m/s or max_angular_velocity in rad/s.

        At most that of the parameter.
        """
        if math.isfinite(value):
            self.limits[name] = max(0.0, min(getattr(self.settings, name), value))

    def hold(self, owner: object, linear: float, angular: float) -> bool:
        """Drive with these shares of the highest speeds, -1 to 1, until HOLD_S have passed.

        Return False if another owner drives, or drove when this one began.
        """
        is_held = self._speeds.hold(owner, linear, angular)
        if is_held:
            self._driven.set()
        return is_held

    def release(self, owner: object) -> None:
        """Stop the robot, if this owner drives it."""
        self._speeds.release(owner)

    def _publish(self) -> None:
        while not rospy.is_shutdown():
            if not self._driven.wait(POLL_PERIOD_S):
                continue
            shares = self._speeds.current()
            while shares is not None and not rospy.is_shutdown():
                self._velocity.publish(twist_msgs.to_msg(
                    shares[0] * self.limits['max_linear_velocity'],
                    shares[1] * self.limits['max_angular_velocity']))
                time.sleep(_PERIOD_S)
                shares = self._speeds.current()
            for _ in range(_STOPS):
                self._velocity.publish(twist_msgs.to_msg(0.0))
            self._driven.clear()
            if self._speeds.current() is not None:      # held again meanwhile
                self._driven.set()

    def _hold_others(self) -> None:
        """Let the other nodes yield as long as somebody drives."""
        services: List[str] = []
        read_s = -math.inf
        while not rospy.is_shutdown():
            if not self._driven.is_set():
                read_s = -math.inf
                self._driven.wait(POLL_PERIOD_S)
                continue
            try:
                if time.monotonic() - read_s > READ_PERIOD_S:      # others may start meanwhile
                    services, read_s = yield_services(self._topic), time.monotonic()
            except timed_xmlrpc.ERRORS as error:
                self._warn('another node may drive the robot too: no master answers: %s',
                           one_line(error))
            # each in a thread: one that does not answer must not keep the others from yielding
            for name in set(services) - self._asked:
                self._asked.add(name)
                threading.Thread(target=self._ask, args=(name,), daemon=True).start()
            time.sleep(YIELD_PERIOD_S)

    def _ask(self, service: str) -> None:
        """Ask a node to yield."""
        try:
            answer = rospy.ServiceProxy(service, Trigger)()
            if not answer.success:
                self._warn('%s: %s', service, answer.message)
        except Exception as error:      # rospy raises more than it documents
            self._warn('another node may drive the robot too: %s', one_line(error))
        finally:
            self._asked.discard(service)


def yield_services(topic: str) -> List[str]:
    """Return the services by which the publishers of a topic can be asked to yield."""
    state = master.calls().state()
    return sorted(node + _SERVICE for node in state.published.get(topic, ())
                  if node + _SERVICE in state.services)
