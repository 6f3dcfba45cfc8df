"""The joints of a robot as a sensor measures them."""
from dataclasses import dataclass
from typing import cast

from img_recog.formats.gazebo_tags import RATE, Row, Tags
from img_recog.settings import Settings, above, setting
from img_recog.simulation.physics.robot import JointStates, SimulatedRobot
from img_recog.simulation.sensors.sensor import Mount, Sensor

# a drive can have them too
TAGS = Tags(('gazebo_ros_joint_state_publisher',), (
    Row('joint_states_period_s', RATE, 'plugin', 'updateRate'),))


@dataclass(frozen=True)
class JointStateSettings(Settings):
    """joint_states_period_s: a multiple of the physics step, in simulated s."""

    joint_states_period_s: float = setting(0.033, above(0))


class JointStateSensor(Sensor):
    """Measures all movable joints."""

    def __init__(self, mount: Mount, _: JointStateSettings):
        self._robot = cast(SimulatedRobot, mount.robot)

    def read(self) -> JointStates:
        """Return the states of the joints."""
        return self._robot.joint_states()
