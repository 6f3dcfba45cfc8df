"""What stands in the world, seen from above."""
import rospy
from visualization_msgs.msg import MarkerArray

from img_recog.conversions import plane_msgs, robot_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.simulation.pictures.footprints import footprints
from img_recog.simulation.simulator import Simulator


class Outlines:
    """Publishes ~world_outlines (visualization_msgs/MarkerArray, latched)."""

    def __init__(self, simulator: Simulator, frame: str, origin: PlanePose):
        """Advertise and publish; origin: of the frame, in the world."""
        self._simulator, self._frame, self._origin = simulator, frame, origin
        self._publisher = rospy.Publisher('~world_outlines', MarkerArray, queue_size=1, latch=True)
        self.publish()

    def publish(self) -> None:
        """Publish what stands there now."""
        self._publisher.publish(plane_msgs.outlines_to_msg(
            footprints(self._simulator.world), self._origin, self._frame,
            robot_msgs.stamp_of(self._simulator.time_s)))
