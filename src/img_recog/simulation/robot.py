"""A robot in a world: its joints, its pose and its motion."""
from typing import Dict, NamedTuple, Optional, Sequence, Tuple

import numpy as np
import pybullet

from img_recog.simulation.description import Description
from img_recog.simulation.geometry import to_rpy
from img_recog.simulation.settings import DriveSettings, SimulationError, SpawnSettings
from img_recog.simulation.world import load_urdf

COLLISION_GROUP = 64            # the bit by which rays leave out the robot that they start in
_DEFAULT_FRICTION = 1.0         # of links that state none (Gazebo's default)


class Motion(NamedTuple):
    """Where a frame of the robot is and how it moves.

    position (3,): m, in the world; orientation: unit quaternion (x, y, z, w), in the world;
    linear (3,), angular (3,): velocity in m/s and rad/s, in the frame itself.
    """

    position: np.ndarray
    orientation: Tuple[float, float, float, float]
    linear: np.ndarray
    angular: np.ndarray


class Pose(NamedTuple):
    """Where the parts of a robot are, enough to draw it.

    position (3,), orientation (x, y, z, w): of the centre of mass, in the world; joints: rad.
    """

    position: Sequence[float]
    orientation: Sequence[float]
    joints: Sequence[float]


class JointStates(NamedTuple):
    """Names, positions (rad), velocities (rad/s) and motor torques (N m) of movable joints."""

    names: Sequence[str]
    positions: Sequence[float]
    velocities: Sequence[float]
    efforts: Sequence[float]


class Robot:
    """The body of a description, driven by two wheels."""

    def __init__(self, description: Description, drive: DriveSettings, spawn: SpawnSettings,
                 client: int):
        """Load the robot into the world of `client`.

        Raises SimulationError when PyBullet cannot load it or a wheel joint is missing.
        """
        self._client = client
        self._spawn = spawn
        self._torques = (drive.wheel_torque, drive.wheel_torque)
        self._body = load_urdf(description.urdf, client)
        joints = _movable_joints(self._body, client)
        self._root, self._frames = description.root, description.frames
        self._link_indices = {_link_name(self._body, index, client): index
                              for index in self._links() if index != -1}
        self._link_indices[description.root] = -1
        self._joint_names = tuple(joints)
        self._joints = tuple(joints.values())
        if drive.left_joint == drive.right_joint:
            raise SimulationError('left_joint: got {!r}, which is right_joint as well; a '
                                  'differential drive has two wheels'.format(drive.left_joint))
        self._wheels = tuple(_wheel(joints, name)
                             for name in (drive.left_joint, drive.right_joint))
        self._mass_in_root = _inertial_pose(self._body, client)
        self._root_in_mass = pybullet.invertTransform(*self._mass_in_root)
        self._set_dynamics(description)
        self.reset()

    def reset(self) -> None:
        """Put the robot back to where it was spawned, at rest, its wheels at 0 rad."""
        spawn = self._spawn
        centre, turned = pybullet.multiplyTransforms(
            (spawn.x_pos, spawn.y_pos, spawn.z_pos),
            pybullet.getQuaternionFromEuler((0, 0, spawn.yaw)), *self._mass_in_root)
        self.place(Pose(centre, turned, [0.0] * len(self._joints)))
        self.set_wheel_velocities((0.0, 0.0))

    def pose(self) -> Pose:
        """Return where the parts are now."""
        centre, turned = pybullet.getBasePositionAndOrientation(
            self._body, physicsClientId=self._client)
        return Pose(centre, turned, self.joint_states().positions)

    def place(self, pose: Pose) -> None:
        """Put the parts where `pose` says, at rest."""
        pybullet.resetBasePositionAndOrientation(self._body, pose.position, pose.orientation,
                                                 physicsClientId=self._client)
        pybullet.resetBaseVelocity(self._body, (0, 0, 0), (0, 0, 0), physicsClientId=self._client)
        for joint, position in zip(self._joints, pose.joints):
            pybullet.resetJointState(self._body, joint, position, 0.0,
                                     physicsClientId=self._client)

    def wheel_velocities(self) -> Tuple[float, float]:
        """Return the angular velocities of the left and right wheel, in rad/s."""
        states = pybullet.getJointStates(self._body, self._wheels, physicsClientId=self._client)
        return states[0][1], states[1][1]

    def set_wheel_velocities(self, velocities: Tuple[float, float]) -> None:
        """Ask the motors of the left and right wheel for these angular velocities, in rad/s."""
        pybullet.setJointMotorControlArray(
            self._body, self._wheels, pybullet.VELOCITY_CONTROL, targetVelocities=velocities,
            forces=self._torques, physicsClientId=self._client)

    def motion(self, frame: Optional[str] = None) -> Motion:
        """Return the motion of a link of the description, by default of the root link.

        Raises SimulationError when there is no such link.
        """
        link, pose = self._carrier(frame or self._root)
        centre, origin, linear, angular = self._link_state(link)
        position, orientation = pybullet.multiplyTransforms(*origin, *pose)
        arm = np.subtract(position, centre)
        to_frame = np.reshape(pybullet.getMatrixFromQuaternion(orientation), (3, 3)).T
        return Motion(np.array(position), orientation,
                      to_frame @ (np.array(linear) + np.cross(angular, arm)),
                      to_frame @ np.array(angular))

    def _carrier(self, frame: str):
        """Return the PyBullet link that carries a frame, and the frame's pose in it."""
        if frame not in self._frames:
            raise SimulationError('robot_description has no link {} (has {})'.format(
                frame, ', '.join(sorted(self._frames))))
        name, pose = self._frames[frame].link, self._frames[frame].pose
        turned = pybullet.getQuaternionFromEuler(to_rpy(pose.rotation).tolist())
        return self._link_indices[name], (pose.translation.tolist(), turned)

    def _link_state(self, link: int):
        """Return centre of mass, frame (position, quaternion) and velocities, in the world."""
        if link == -1:
            # PyBullet speaks of the centre of mass, whose frame is turned to the principal axes
            centre, turned = pybullet.getBasePositionAndOrientation(
                self._body, physicsClientId=self._client)
            origin = pybullet.multiplyTransforms(centre, turned, *self._root_in_mass)
            return (centre, origin, *pybullet.getBaseVelocity(
                self._body, physicsClientId=self._client))
        state = pybullet.getLinkState(self._body, link, computeLinkVelocity=1,
                                      computeForwardKinematics=1, physicsClientId=self._client)
        return state[0], state[4:6], state[6], state[7]

    def joint_states(self) -> JointStates:
        """Return the states of all movable joints, in the order of the description."""
        states = pybullet.getJointStates(self._body, self._joints, physicsClientId=self._client)
        return JointStates(self._joint_names, [state[0] for state in states],
                           [state[1] for state in states], [state[3] for state in states])

    def mass(self) -> float:
        """Return the mass of all links as PyBullet simulates them, in kg."""
        return sum(pybullet.getDynamicsInfo(self._body, link, physicsClientId=self._client)[0]
                   for link in self._links())

    def _links(self) -> range:
        return range(-1, pybullet.getNumJoints(self._body, physicsClientId=self._client))

    def _set_dynamics(self, description: Description) -> None:
        for name, link in self._link_indices.items():
            pybullet.setCollisionFilterGroupMask(self._body, link, COLLISION_GROUP, ~0,
                                                 physicsClientId=self._client)
            pybullet.changeDynamics(
                self._body, link, linearDamping=0, angularDamping=0, jointDamping=0,
                lateralFriction=description.friction.get(name, _DEFAULT_FRICTION),
                physicsClientId=self._client)
        for wheel in self._wheels:
            pybullet.changeDynamics(
                self._body, wheel, spinningFriction=self._torsional_friction(wheel),
                physicsClientId=self._client)
        # every joint comes with a motor that holds it; only the wheels are to have one
        passive = [joint for joint in self._joints if joint not in self._wheels]
        pybullet.setJointMotorControlArray(
            self._body, passive, pybullet.VELOCITY_CONTROL, forces=[0.0] * len(passive),
            physicsClientId=self._client)

    def _torsional_friction(self, wheel: int) -> float:
        """Return the spinning friction of a wheel in m (torque against turning a load of 1 N).

        A tyre as wide as w stands on a line; with even pressure it resists turning about the
        vertical by mu N w / 4. PyBullet sees the line as one or two points and misses that: a
        robot whose wheels slip would spin out.
        """
        friction = pybullet.getDynamicsInfo(self._body, wheel, physicsClientId=self._client)[1]
        shapes = pybullet.getCollisionShapeData(self._body, wheel, physicsClientId=self._client)
        widths = [shape[3][0] for shape in shapes if shape[2] == pybullet.GEOM_CYLINDER]
        return friction * max(widths, default=0.0) / 4


def _movable_joints(body: int, client: int) -> Dict[str, int]:
    joints = {}
    for index in range(pybullet.getNumJoints(body, physicsClientId=client)):
        info = pybullet.getJointInfo(body, index, physicsClientId=client)
        if info[2] != pybullet.JOINT_FIXED:
            joints[info[1].decode()] = index
    return joints


def _wheel(joints: Dict[str, int], name: str) -> int:
    if name not in joints:
        raise SimulationError('robot_description has no movable joint {} (has {}); a wheel needs '
                              'one'.format(name, ', '.join(joints) or 'none'))
    return joints[name]


def _link_name(body: int, link: int, client: int) -> str:
    return pybullet.getJointInfo(body, link, physicsClientId=client)[12].decode()


def _inertial_pose(body: int, client: int):
    """Return position and quaternion of the base's inertial frame in its link frame."""
    return pybullet.getDynamicsInfo(body, -1, physicsClientId=client)[3:5]
