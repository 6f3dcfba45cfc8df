"""The joints of a robot as a sensor measures them."""
from dataclasses import dataclass
from typing import cast

from img_recog.formats.gazebo_tags import NAMES, RATE, Row, Tags
from img_recog.settings import Settings, above, any_value, setting
from img_recog.simulation.physics.robot import JointStates, RobotBody
from img_recog.simulation.sensors.sensor import Mount, Sensor
from img_recog.simulation.simulation_settings import names_in

# a drive can have them too
TAGS = Tags(('gazebo_ros_joint_state_publisher',), (
    Row('joint_states_period_s', RATE, 'plugin', 'updateRate'),
    Row('joint_states_joints', NAMES, 'plugin', 'jointName')),
    defaults={'joint_state_publisher': {'joint_states_period_s': 0.01}})


@dataclass(frozen=True)
class JointStateSettings(Settings):
    """joint_states_period_s: a multiple of the physics step, in simulated s. joint_states_joints:
    names of joints with commas, '' for all that move; those have efforts, too.
    """

    joint_states_period_s: float = setting(0.01, above(0))
    joint_states_joints: str = setting('', any_value())


class JointStateSensor(Sensor):
    """Measures all movable joints, or as gazebo_plugins does, those that are given."""

    def __init__(self, mount: Mount, settings: JointStateSettings):
        self._robot = cast(RobotBody, mount.robot)
        self._given = names_in(settings.joint_states_joints)

    def read(self) -> JointStates:
        """Return the states of the joints."""
        states = self._robot.joint_states()
        if not self._given:
            return states
        order = [states.names.index(name) for name in self._given if name in states.names]
        return JointStates([states.names[number] for number in order],
                           [states.positions[number] for number in order],
                           [states.velocities[number] for number in order], [])
