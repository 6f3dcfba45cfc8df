"""A body in the world, spoken of by the frame of its root link.

PyBullet itself speaks of the center of mass, in a frame turned to the principal axes.
"""
import math
from typing import Dict, NamedTuple, Sequence, Tuple

import numpy as np
import pybullet

Vector = Sequence[float]
Quaternion = Sequence[float]        # x, y, z, w


class Pose(NamedTuple):
    """Where the parts of a body are, enough to draw it.

    position (3,) in m, orientation (unit quaternion x, y, z, w): of the root link's frame, in the
    world; joints: rad or m, of the movable joints in their order.
    """

    position: Vector
    orientation: Quaternion
    joints: Sequence[float]


class Motion(NamedTuple):
    """Where a frame is and how it moves.

    position (3,): m, in the world; orientation: unit quaternion (x, y, z, w), in the world;
    linear (3,), angular (3,): velocity in m/s and rad/s, in the frame itself.
    """

    position: np.ndarray
    orientation: Tuple[float, float, float, float]
    linear: np.ndarray
    angular: np.ndarray

    @property
    def yaw(self) -> float:
        """The heading in rad, from -pi to pi."""
        x, y, z, w = self.orientation
        return math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))


class Body:
    """Wraps the body number `body` of the physics client `client`.

    fixed: whether its root link never moves.
    """

    def __init__(self, body: int, client: int, fixed: bool = False):
        self.number = body
        self.client = client
        self.fixed = fixed
        self.links = range(-1, pybullet.getNumJoints(body, physicsClientId=client))
        self.joints = self._movable_joints()
        self.name = pybullet.getBodyInfo(body, physicsClientId=client)[1].decode()
        self.mass_in_root = pybullet.getDynamicsInfo(body, -1, physicsClientId=client)[3:5]
        self._root_in_mass = pybullet.invertTransform(*self.mass_in_root)
        self._start = self.pose()

    def _movable_joints(self) -> Dict[str, int]:
        joints = {}
        for index in self.links[1:]:
            info = pybullet.getJointInfo(self.number, index, physicsClientId=self.client)
            if info[2] != pybullet.JOINT_FIXED:
                joints[info[1].decode()] = index
        return joints

    def mass(self) -> float:
        """Return the mass of all links as PyBullet simulates them, in kg."""
        return sum(pybullet.getDynamicsInfo(self.number, link, physicsClientId=self.client)[0]
                   for link in self.links)

    def joint_values(self) -> Sequence[tuple]:
        """Return position, velocity, reaction and motor effort of each movable joint."""
        return pybullet.getJointStates(self.number, tuple(self.joints.values()),
                                       physicsClientId=self.client) or ()

    def pose(self) -> Pose:
        """Return where the parts are now."""
        position, orientation = self.transform_in_world(*self._root_in_mass)
        return Pose(position, orientation, [value[0] for value in self.joint_values()])

    def transform_in_world(self, position: Vector, orientation: Quaternion) -> tuple:
        """Return position and orientation, in the world, of a pose given in the mass frame."""
        center = pybullet.getBasePositionAndOrientation(self.number, physicsClientId=self.client)
        return pybullet.multiplyTransforms(*center, position, orientation)

    def place(self, pose: Pose) -> None:
        """Put the parts where `pose` says, at rest."""
        center, turned = pybullet.multiplyTransforms(pose.position, pose.orientation,
                                                     *self.mass_in_root)
        pybullet.resetBasePositionAndOrientation(self.number, center, turned,
                                                 physicsClientId=self.client)
        pybullet.resetBaseVelocity(self.number, (0, 0, 0), (0, 0, 0), physicsClientId=self.client)
        for joint, position in zip(self.joints.values(), pose.joints):
            pybullet.resetJointState(self.number, joint, position, 0.0,
                                     physicsClientId=self.client)

    def reset(self) -> None:
        """Put the parts where they were at first."""
        self.place(self._start)

    def motion(self) -> Motion:
        """Return the motion of the root link's frame."""
        return self.motion_of_base(self._root_in_mass)

    def motion_of_base(self, in_mass: Tuple[Vector, Quaternion]) -> Motion:
        """Return the motion of a frame that the base carries, at a pose in its mass frame."""
        center, turned = pybullet.getBasePositionAndOrientation(self.number,
                                                                physicsClientId=self.client)
        linear, angular = pybullet.getBaseVelocity(self.number, physicsClientId=self.client)
        return moving(pybullet.multiplyTransforms(center, turned, *in_mass), center, linear,
                      angular)

    def move(self, linear: Vector, angular: Vector) -> None:
        """Set the velocity of the root link: m/s and rad/s, in the world."""
        center, _ = pybullet.getBasePositionAndOrientation(self.number,
                                                           physicsClientId=self.client)
        arm = np.subtract(center, self.pose().position)
        at_center = np.array(linear) + np.cross(angular, arm)
        pybullet.resetBaseVelocity(self.number, at_center.tolist(), list(angular),
                                   physicsClientId=self.client)


def rotation_matrix(orientation: Quaternion) -> np.ndarray:
    """Return the matrix (3, 3) that turns vectors of the child frame into the parent's."""
    return np.array(pybullet.getMatrixFromQuaternion(orientation)).reshape(3, 3)


def moving(frame: Tuple[Vector, Quaternion], center: Vector, linear: Vector,
           angular: Vector) -> Motion:
    """Return the motion of a frame on a rigid part.

    frame: position and orientation in the world; center, linear, angular: a point of the part,
    its velocity and that of the part, in the world.
    """
    position, orientation = frame
    x, y, z = (a - b for a, b in zip(position, center))
    (vx, vy, vz), (wx, wy, wz) = linear, angular
    at_frame = vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x
    in_frame = np.array((at_frame, angular)) @ rotation_matrix(orientation)
    return Motion(np.array(position), orientation, in_frame[0], in_frame[1])
