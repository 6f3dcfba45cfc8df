"""A robot in a world: its joints and the motors of its wheels."""
from typing import NamedTuple, Sequence, Tuple

import pybullet

from img_recog import rotations
from img_recog.errors import SimulationError
from img_recog.model import CONTINUOUS, Model
from img_recog.simulation.physics import build, tires
from img_recog.simulation.physics.body import MAX_JOINT_VELOCITY, BodyPose
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.physics.surfaces import Surfaces
from img_recog.simulation.simulation_settings import SpawnSettings


class JointStates(NamedTuple):
    """Names, positions (rad), velocities (rad/s) and motor torques (N m) of movable joints."""

    names: Sequence[str]
    positions: Sequence[float]
    velocities: Sequence[float]
    efforts: Sequence[float]


class Motors(NamedTuple):
    """What drives a robot.

    joints: of the wheels, each with the setting that names it; torque: the maximum of a wheel in
    N m; slides: whether the robot has no friction, because its base itself is moved.
    """

    joints: Sequence[Tuple[str, str]]
    torque: float
    slides: bool = False


class RobotBody(FramedBody):
    """The body of a model, with motors.

    spawn: where `reset` moves it.
    """

    def __init__(self, model: Model, motors: Motors, spawn: SpawnSettings,
                 physics_client_id: int):
        """Load the robot into a physics client.

        Raises SimulationError when PyBullet cannot load it or a wheel joint is missing.
        """
        shod = tires.added(model, [name for _, name in motors.joints])
        super().__init__(build.load(shod, physics_client_id, exact_hulls=True), physics_client_id,
                         model, loaded=shod)
        self.name, self.slides, self.exact_hulls = model.name, motors.slides, True
        self.spawn = spawn
        check_motors(motors, self)
        self._wheels = tuple(self.joints[name] for _, name in motors.joints)
        # gazebo_plugins' diff_drive publishes the right wheel before the left one
        right_first = sorted(motors.joints, key=lambda joint: joint[0] != 'right_joint')
        self._published = {name: self.joints[name] for name in dict.fromkeys(
            (*(name for _, name in right_first), *self.joints))}
        self._torques = (motors.torque,) * len(self._wheels)
        # without friction, nothing would stop a wheel again that turned a little
        self.driven = (*self._wheels, *(
            self.joints[joint.name] for joint in model.joints
            if motors.slides and joint.kind == CONTINUOUS and joint.name in self.joints))
        Surfaces.set_friction(self)
        self.release_joints()
        self.reset()

    def reset(self) -> None:
        """Move the robot back to where it was spawned, at rest, its wheels at 0 rad."""
        spawn = self.spawn
        self.place(BodyPose((spawn.x_pos, spawn.y_pos, spawn.z_pos),
                            rotations.of_yaw(spawn.yaw), [0.0] * len(self.joints)))
        self.stop_wheels()

    def stop_wheels(self) -> None:
        """Let the motors of the wheels hold them."""
        self.set_wheel_velocities((0.0,) * len(self._wheels))

    def wheel_positions(self) -> Tuple[float, ...]:
        """Return how far each wheel has turned since the reset, in rad, in the motors' order."""
        return tuple(state[0] for state in self.joint_values(self._wheels))

    def wheel_velocities(self) -> Tuple[float, ...]:
        """Return the angular velocities of the wheels, in rad/s."""
        return tuple(state[1] for state in self.joint_values(self._wheels))

    def set_wheel_velocities(self, velocities: Sequence[float]) -> None:
        """Set the target velocities of the motors of the wheels, in rad/s."""
        pybullet.setJointMotorControlArray(
            self.body_id, self._wheels, pybullet.VELOCITY_CONTROL,
            targetVelocities=[max(-MAX_JOINT_VELOCITY, min(velocity, MAX_JOINT_VELOCITY))
                              for velocity in velocities],
            forces=self._torques, **self.client)

    def joint_states(self) -> JointStates:
        """Return the states of all movable joints.

        Right wheels come first, then left ones, then the others in the order of the model.
        """
        states = self.joint_values(tuple(self._published.values()))
        return JointStates(tuple(self._published), [state[0] for state in states],
                           [state[1] for state in states], [state[3] for state in states])


def check_motors(motors: Motors, body: FramedBody) -> None:
    """Raise SimulationError if the body of a model has not all joints of the motors."""
    for setting, name in motors.joints:
        if name not in body.joints:
            raise SimulationError(
                'the robot has no movable joint {} (movable joints: {})'.format(
                    name, ', '.join(body.joints) or 'none'),
                'set {} to the joint of a wheel; one that moves nothing with an <inertial> is '
                'left out'.format(setting))
