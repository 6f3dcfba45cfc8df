"""What a visitor may do with the simulation: pause, reset, move the robot."""
import math

import rospy
from geometry_msgs.msg import PoseStamped
from std_msgs.msg import Header
from std_srvs.srv import Empty

from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.errors import UserError, one_line

ACTIONS = ('pause_physics', 'unpause_physics', 'reset_world', 'reset_simulation')
_TIMEOUT_S = 2.0
_MAX_M = 1000.0


class SimulationControl:
    """Calls the services of /gazebo (std_srvs/Empty), and publishes gazebo/set_pose."""

    def __init__(self) -> None:
        self._pose = rospy.Publisher('gazebo/set_pose', PoseStamped, queue_size=1)

    def call(self, action: str) -> None:
        """Call one of ACTIONS; raise UserError if that fails. Waits: not for the event loop."""
        name = rospy.resolve_name('gazebo/' + action)
        try:
            rospy.wait_for_service(name, _TIMEOUT_S)
            rospy.ServiceProxy(name, Empty)()
        except (rospy.ROSException, rospy.ServiceException) as error:
            raise UserError('{}: {}'.format(name, one_line(error)), 'is the simulator running?')

    def set_pose(self, x: float, y: float, yaw: float) -> None:
        """Move the robot; x and y in m, yaw in rad, in the frame of the odometry."""
        if not all(map(math.isfinite, (x, y, yaw))) or max(abs(x), abs(y)) > _MAX_M:
            raise UserError('cannot move the robot to x {}, y {}, yaw {}'.format(x, y, yaw),
                            'choose a point of the map')
        self._pose.publish(plane_msgs.pose_to_msg(
            PlanePose(x, y, yaw), Header(stamp=rospy.Time.now(), frame_id='odom')))
