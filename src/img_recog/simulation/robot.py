"""A robot in a world: its frames, its joints and its motors."""
from typing import NamedTuple, Optional, Sequence, Tuple

import pybullet

from img_recog.simulation.body import Body, Motion, Pose, moving
from img_recog.simulation.description import Description
from img_recog.simulation.geometry import to_rpy
from img_recog.simulation.loading import load_urdf
from img_recog.simulation.settings import DriveSettings, SimulationError, SpawnSettings

COLLISION_GROUP = 64            # the bit by which rays leave out the robot that they start in
_DEFAULT_FRICTION = 1.0         # of links that state none (Gazebo's default)


class JointStates(NamedTuple):
    """Names, positions (rad), velocities (rad/s) and motor torques (N m) of movable joints."""

    names: Sequence[str]
    positions: Sequence[float]
    velocities: Sequence[float]
    efforts: Sequence[float]


class Robot(Body):
    """The body of a description, driven by two wheels.

    root: name of its root link.
    """

    def __init__(self, description: Description, drive: DriveSettings, spawn: SpawnSettings,
                 client: int):
        """Load the robot into the world of `client`.

        Raises SimulationError when PyBullet cannot load it or a wheel joint is missing.
        """
        super().__init__(load_urdf(description.urdf, client), client)
        self.name = description.name
        self._spawn = spawn
        self._torques = (drive.wheel_torque, drive.wheel_torque)
        self.root, self._frames = description.root, description.frames
        self._link_indices = {_link_name(self, index): index for index in self.links[1:]}
        self._link_indices[description.root] = -1
        self._carriers = {}
        self._joint_names = tuple(self.joints)
        if drive.left_joint == drive.right_joint:
            raise SimulationError('left_joint: got {!r}, which is right_joint as well; a '
                                  'differential drive has two wheels'.format(drive.left_joint))
        self._wheels = tuple(self._wheel(name)
                             for name in (drive.left_joint, drive.right_joint))
        self._set_dynamics(description)
        self.reset()

    def reset(self) -> None:
        """Put the robot back to where it was spawned, at rest, its wheels at 0 rad."""
        spawn = self._spawn
        self.place(Pose((spawn.x_pos, spawn.y_pos, spawn.z_pos),
                        pybullet.getQuaternionFromEuler((0, 0, spawn.yaw)),
                        [0.0] * len(self.joints)))
        self.set_wheel_velocities((0.0, 0.0))

    def wheel_positions(self) -> Tuple[float, float]:
        """Return how far the left and right wheel have turned since the reset, in rad."""
        left, right = self._wheel_states()
        return left[0], right[0]

    def wheel_velocities(self) -> Tuple[float, float]:
        """Return the angular velocities of the left and right wheel, in rad/s."""
        left, right = self._wheel_states()
        return left[1], right[1]

    def _wheel_states(self) -> tuple:
        return pybullet.getJointStates(self.number, self._wheels, physicsClientId=self.client)

    def set_wheel_velocities(self, velocities: Tuple[float, float]) -> None:
        """Ask the motors of the left and right wheel for these angular velocities, in rad/s."""
        pybullet.setJointMotorControlArray(
            self.number, self._wheels, pybullet.VELOCITY_CONTROL, targetVelocities=velocities,
            forces=self._torques, physicsClientId=self.client)

    def motion(self, frame: Optional[str] = None) -> Motion:
        """Return the motion of a link of the description, by default of the root link.

        Raises SimulationError when there is no such link.
        """
        link, pose = self._carrier(frame or self.root)
        if link == -1:
            return self.motion_of_base(pose)
        state = pybullet.getLinkState(self.number, link, computeLinkVelocity=1,
                                      computeForwardKinematics=1, physicsClientId=self.client)
        return moving(pybullet.multiplyTransforms(*state[4:6], *pose), state[0], *state[6:8])

    def has_frame(self, frame: str) -> bool:
        """Return whether the description has this link."""
        return frame in self._frames

    def check_frame(self, setting: str, frame: str) -> None:
        """Raise SimulationError when the frame that a setting names is no link."""
        try:
            self._carrier(frame)
        except SimulationError as error:
            raise SimulationError('{}: {}'.format(setting, error))

    def _carrier(self, frame: str):
        """Return the PyBullet link that carries a frame, and the frame's pose in it.

        The pose is in the link's frame, or, for the base, in the frame of its center of mass.
        """
        if frame not in self._frames:
            raise SimulationError('robot_description has no link {} (has {})'.format(
                frame, ', '.join(sorted(self._frames))))
        if frame not in self._carriers:
            name, pose = self._frames[frame].link, self._frames[frame].pose
            link = self._link_indices[name]
            turned = pybullet.getQuaternionFromEuler(to_rpy(pose.rotation).tolist())
            in_link = pose.translation.tolist(), turned
            self._carriers[frame] = link, in_link if link != -1 else (
                pybullet.multiplyTransforms(*pybullet.invertTransform(*self.mass_in_root),
                                            *in_link))
        return self._carriers[frame]

    def joint_states(self) -> JointStates:
        """Return the states of all movable joints, in the order of the description."""
        states = self.joint_values()
        return JointStates(self._joint_names, [state[0] for state in states],
                           [state[1] for state in states], [state[3] for state in states])

    def _wheel(self, name: str) -> int:
        if name not in self.joints:
            raise SimulationError('robot_description has no movable joint {} (has {}); a wheel '
                                  'needs one'.format(name, ', '.join(self.joints) or 'none'))
        return self.joints[name]

    def _set_dynamics(self, description: Description) -> None:
        for name, link in self._link_indices.items():
            pybullet.setCollisionFilterGroupMask(self.number, link, COLLISION_GROUP, ~0,
                                                 physicsClientId=self.client)
            pybullet.changeDynamics(
                self.number, link, linearDamping=0, angularDamping=0, jointDamping=0,
                lateralFriction=description.friction.get(name, _DEFAULT_FRICTION),
                physicsClientId=self.client)
        for wheel in self._wheels:
            pybullet.changeDynamics(
                self.number, wheel, spinningFriction=self._torsional_friction(wheel),
                physicsClientId=self.client)
        # every joint comes with a motor that holds it; only the wheels are to have one
        passive = [joint for joint in self.joints.values() if joint not in self._wheels]
        pybullet.setJointMotorControlArray(
            self.number, passive, pybullet.VELOCITY_CONTROL, forces=[0.0] * len(passive),
            physicsClientId=self.client)

    def _torsional_friction(self, wheel: int) -> float:
        """Return the spinning friction of a wheel in m (torque against turning a load of 1 N).

        A tyre as wide as w stands on a line; with even pressure it resists turning about the
        vertical by mu N w / 4. PyBullet sees the line as one or two points and misses that: a
        robot whose wheels slip would spin out.
        """
        friction = pybullet.getDynamicsInfo(self.number, wheel, physicsClientId=self.client)[1]
        shapes = pybullet.getCollisionShapeData(self.number, wheel, physicsClientId=self.client)
        widths = [shape[3][0] for shape in shapes if shape[2] == pybullet.GEOM_CYLINDER]
        return friction * max(widths, default=0.0) / 4


def _link_name(body: Body, link: int) -> str:
    return pybullet.getJointInfo(body.number, link, physicsClientId=body.client)[12].decode()
