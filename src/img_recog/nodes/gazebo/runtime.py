"""What can be changed while the simulation runs, beside the services of Gazebo."""
from dataclasses import dataclass
from typing import Protocol

import rospy
from geometry_msgs.msg import PoseStamped

from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose, PoseError
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.ros.reconfigure import Reconfigurable
from img_recog.ros.throttle import ThrottledWarning
from img_recog.settings import Settings, one_of, setting
from img_recog.simulation.settings import REAL_TIME_FACTORS, VIEWS, SimulationError

_WORLD_FRAMES = ('', 'world')


@dataclass(frozen=True)
class RuntimeSettings(Settings):
    """Parameters that dynamic_reconfigure changes; see PhysicsSettings and ViewSettings."""

    real_time_factor: float = setting(
        1.0, REAL_TIME_FACTORS, 'simulated seconds per second of wall time; 0: no limit')
    view: str = setting('above', one_of(*VIEWS), 'viewpoint of ~view/image_raw')


class Simulation(Protocol):
    """The node; the methods are called in the thread that simulates."""

    def configure(self, settings: RuntimeSettings) -> None:
        """Apply settings."""

    def move_robot(self, pose: PlanePose) -> None:
        """Move the robot in the world."""


class RuntimeControl:
    """Serves the parameters of RuntimeSettings, and moves the robot to ~set_pose.

    Subscribes: ~set_pose (geometry_msgs/PoseStamped, in the world or the frame of the odometry).
    """

    def __init__(self, settings: RuntimeSettings, simulation: Simulation, calls: ServiceCalls,
                 odom_frame: str):
        self._simulation, self._calls = simulation, calls
        self._frames = _WORLD_FRAMES + (odom_frame,)
        self._warn = ThrottledWarning()
        self._reconfigurable = Reconfigurable(
            settings, lambda new: calls.call(lambda: simulation.configure(new)))
        rospy.Subscriber('~set_pose', PoseStamped, self._set_pose, queue_size=1, tcp_nodelay=True)

    def _set_pose(self, msg: PoseStamped) -> None:
        try:
            if msg.header.frame_id.lstrip('/') not in self._frames:
                raise PoseError('its frame is {!r}, expected {}'.format(
                    msg.header.frame_id[:100], ' or '.join(filter(None, self._frames))))
            pose = plane_msgs.pose_from_msg(msg)
            self._calls.call(lambda: self._simulation.move_robot(pose))
        except (PoseError, SimulationError) as error:
            self._warn('ignored a message on %s: %s', rospy.resolve_name('~set_pose'), error)


def timeout_scale(real_time_factor: float) -> float:
    """Return how many times longer timeouts in simulated time are, to be as long in wall time.

    Like demo.launch: never shorter, and for "as fast as possible" 100 times.
    """
    return min(100.0, max(1.0, real_time_factor or 100.0))
