"""A publisher of velocities that stops the robot when its node ends."""
import threading
from typing import Callable

from geometry_msgs.msg import Twist

from img_recog.ros import lifecycle
from img_recog.ros.transport.direct_publisher import DirectPublisher


class StoppingPublisher:
    """Publishes geometry_msgs/Twist from any thread, and a zero when the node is shut down.

    Nothing follows that zero: the threads of a node continue until all shutdown hooks have run.
    """

    def __init__(self, topic: str, is_driven: Callable[[], bool] = lambda: True):
        """Advertise `topic`.

        is_driven: whether the robot has to be stopped when the node is shut down.
        """
        self._publisher, self._is_driven = DirectPublisher(topic, Twist), is_driven
        self._lock, self._has_ended = threading.Lock(), False
        lifecycle.on_shutdown(self._end)

    def get_num_connections(self) -> int:
        """Return the number of subscribers."""
        return self._publisher.get_num_connections()

    def publish(self, velocity: Twist) -> None:
        """Send a velocity, unless the node was shut down."""
        with self._lock:
            if not self._has_ended:
                self._publisher.publish(velocity)

    def _end(self) -> None:
        with self._lock:
            self._has_ended = True
            if self._is_driven():
                self._publisher.publish(Twist())
