"""What a visitor may do with the simulation: pause, reset, move the robot."""
import math
import threading
from typing import Callable

import rospy
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header
from std_srvs.srv import Empty

from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.errors import UserError, one_line

_TIMEOUT_S = 10.0
_MAX_M = 1000.0
_one_call = threading.Lock()        # a simulator that hangs must not hold all threads of the page


def call(action: str) -> None:
    """Call a service of /gazebo (std_srvs/Empty); raise UserError if that fails.

    Waits: not for the event loop.
    """
    name = rospy.resolve_name('gazebo/' + action)
    if not _one_call.acquire(blocking=False):
        raise UserError('{}: the last call has not ended'.format(name),
                        'is the simulator running?')
    try:
        rospy.wait_for_service(name, _TIMEOUT_S)
        rospy.ServiceProxy(name, Empty)()
    except (rospy.ROSException, rospy.ServiceException) as error:
        raise UserError('{}: {}'.format(name, one_line(error)), 'is the simulator running?')
    finally:
        _one_call.release()


class PosePublisher:
    """Publishes gazebo/set_pose (geometry_msgs/PoseStamped), or gazebo/ROBOT/set_pose."""

    def __init__(self, robot: str, frame_id: Callable[[], str]):
        """Advertise; robot: its namespace, or ''; frame_id: returns the frame of the poses."""
        self._frame_id = frame_id
        self._publisher = rospy.Publisher('/'.join(filter(None, ('gazebo', robot, 'set_pose'))),
                                          PoseStamped, queue_size=1)

    def publish(self, x: float, y: float, yaw: float) -> None:
        """Move the robot; x and y in m, yaw in rad, in the frame of the odometry.

        Raises UserError for a pose that is not allowed.
        """
        self._publisher.publish(place_to_msg(x, y, yaw, self._frame_id()))


def place_to_msg(x: float, y: float, yaw: float, frame_id: str) -> PoseStamped:
    """Return the message for a place that a visitor has chosen; m and rad.

    Raises UserError for one that is not allowed.
    """
    if not all(map(math.isfinite, (x, y, yaw))) or max(abs(x), abs(y)) > _MAX_M:
        raise UserError('cannot move the robot to x {}, y {}, yaw {}'.format(x, y, yaw),
                        'choose a point within {:g} m'.format(_MAX_M))
    return plane_msgs.pose_to_msg(PlanePose(x, y, yaw),
                                  Header(stamp=rospy.Time.now(), frame_id=frame_id))
