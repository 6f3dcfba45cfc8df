"""The topic that moves a robot."""
from typing import Callable

import rospy
from geometry_msgs.msg import PoseStamped

from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose, PoseError
from img_recog.nodes.gazebo.names import Names
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.ros.log.throttle import ThrottledWarning
from img_recog.simulation.settings import SimulationError

_WORLD_FRAMES = ('', 'world')


class PoseTopic:
    """Moves a robot to what is published on ~set_pose, or ~NAMESPACE/set_pose.

    The poses (geometry_msgs/PoseStamped) are in the world or in the frame of the odometry.
    """

    def __init__(self, names: Names, odom_frame: str, calls: ServiceCalls,
                 origin: Callable[[], PlanePose], move: Callable[[PlanePose], None]):
        """Subscribe.

        origin: returns where the odometry is zero in the world. move: moves the robot; in the
        thread that simulates, both.
        """
        self._topic = rospy.resolve_name('~' + names.topic('set_pose'))
        self._odom_frame = names.frame(odom_frame)
        self._frames = _WORLD_FRAMES + (self._odom_frame,)
        self._calls, self._origin, self._move = calls, origin, move
        self._warn = ThrottledWarning()
        self._subscriber = rospy.Subscriber(self._topic, PoseStamped, self._set, queue_size=1,
                                            tcp_nodelay=True)

    def _set(self, msg: PoseStamped) -> None:
        try:
            frame = msg.header.frame_id.lstrip('/')
            if frame not in self._frames:
                raise PoseError('its frame is {!r}, expected {}'.format(
                    msg.header.frame_id[:100], ' or '.join(filter(None, self._frames))))
            pose = plane_msgs.pose_from_msg(msg)
            self._calls.call(lambda: self._move(
                self._origin().compose(pose) if frame == self._odom_frame else pose))
        except (PoseError, SimulationError) as error:
            self._warn('ignored a message on %s: %s', self._topic, error)

    def close(self) -> None:
        """End the subscription."""
        self._subscriber.unregister()
