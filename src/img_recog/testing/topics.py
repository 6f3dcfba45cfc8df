"""The newest messages of topics, and what they say about a robot."""
from typing import Any, Callable, Dict, NamedTuple, Optional

import numpy as np
from nav_msgs.msg import Odometry

from img_recog import rotations
from img_recog.ros.transport.settled_subscriber import SettledSubscriber

_BUFFER_BYTES = 1 << 25     # larger than an image


class Pose(NamedTuple):
    """Where a robot is, and how it moves, by its odometry.

    x, y: in m; yaw: in rad, both in the frame of the odometry; linear, angular: velocities forward
    and to the left, in m/s and rad/s; time_s: simulated time.
    """

    x: float
    y: float
    yaw: float
    linear: float
    angular: float
    time_s: float

    def __str__(self) -> str:
        return 'x {:.3f} m, y {:.3f} m, yaw {:.3f} rad at {:.3f} s'.format(
            self.x, self.y, self.yaw, self.time_s)


class Picture(NamedTuple):
    """An image. pixels: (height, width, 3), uint8, BGR; time_s: its stamp."""

    pixels: np.ndarray
    time_s: float


def pose_from_msg(msg: Odometry) -> Pose:
    """Return the pose in a message."""
    place, turn, twist = msg.pose.pose.position, msg.pose.pose.orientation, msg.twist.twist
    return Pose(place.x, place.y, rotations.yaw((turn.x, turn.y, turn.z, turn.w)),
                twist.linear.x, twist.angular.z, msg.header.stamp.to_sec())


class Topics:
    """Keeps the newest message of each topic that was subscribed to."""

    def __init__(self) -> None:
        self._subscribers: Dict[str, SettledSubscriber] = {}
        self._newest: Dict[str, Any] = {}

    @property
    def types(self) -> Dict[str, str]:
        """The types of these topics, by their names."""
        return {name: each.type for name, each in self._subscribers.items()}

    def subscribe(self, name: str, data_class: type,
                  notify: Callable[[Any], None] = lambda msg: None) -> None:
        """Subscribe to a topic, once; notify: is called with each message, in another thread."""
        if name in self._subscribers:
            return

        def keep(msg: Any, _: object) -> None:
            self._newest[name] = msg
            notify(msg)
        self._subscribers[name] = SettledSubscriber(name, data_class, keep, _BUFFER_BYTES)

    def newest(self, name: str) -> Optional[Any]:
        """Return the newest message, None if there is none."""
        return self._newest.get(name)

    def is_settled(self) -> bool:
        """Return whether all messages that have arrived are kept."""
        return all(each.is_settled() for each in self._subscribers.values())

    def close(self) -> None:
        """Unsubscribe."""
        for each in self._subscribers.values():
            each.unregister()
        self._subscribers.clear()
