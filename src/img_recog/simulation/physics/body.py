"""A body in the world, described by the frame of its root link.

PyBullet itself uses the center of mass, in a frame aligned with the principal axes of inertia.
"""
import math
from typing import Dict, List, NamedTuple, Optional, Sequence, Set, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.rotations import Quaternion, Transform
from img_recog.simulation.physics.client import center, client_argument, link_indices

Vector = Sequence[float]

# rad/s. At its default of 100, which the command of 10 m/s exceeds, PyBullet cuts the speed of the
# wheels, while their motors go on and turn the robot over.
MAX_JOINT_VELOCITY = 1e5
_REST = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


class BodyPose(NamedTuple):
    """Where the parts of a body are: enough to draw it.

    position (3,) in m and orientation (unit quaternion x, y, z, w) of the root link's frame in the
    world; joints: positions of the movable joints in their order, rad or m.
    """

    position: Vector
    orientation: Quaternion
    joints: Sequence[float]


class BodyState(NamedTuple):
    """All of the state of a body.

    center: position and orientation of the center of mass of the base; velocity: linear and
    angular, of that; joints: position and velocity of each movable joint. In m, m/s, rad, rad/s.
    """

    center: Tuple[Vector, Quaternion]
    velocity: Tuple[Vector, Vector]
    joints: Sequence[Tuple[float, float]]

    def at_rest(self) -> 'BodyState':
        """Return the same position without velocity."""
        return BodyState(self.center, _REST, [(position, 0.0) for position, _ in self.joints])


class FrameState(NamedTuple):
    """A frame fixed to a rigid part, and how the part moves; all in the world.

    frame: position and orientation; point: any point of the part, and linear: the velocity of
    that point; angular: the angular velocity of the part. In m, m/s and rad/s.
    """

    frame: Tuple[Vector, Quaternion]
    point: Vector
    linear: Vector
    angular: Vector


class Motion(NamedTuple):
    """Where a frame is and how it moves.

    position (3,): m, in the world; orientation: unit quaternion (x, y, z, w), in the world;
    linear (3,), angular (3,): velocity in m/s and rad/s, in the frame itself.
    """

    position: np.ndarray
    orientation: Quaternion
    linear: np.ndarray
    angular: np.ndarray

    @property
    def yaw(self) -> float:
        """The heading in rad, from -pi to pi."""
        return rotations.yaw(self.orientation)


class ContactPoint(NamedTuple):
    """A point at which a body touches another one or itself.

    link: PyBullet's number of the link of the body; other: PyBullet's id of the other body;
    depth_m: how deep they are in one another, below 0 for a gap; up: the vertical part of the
    normal, from -1 to 1; force: along the normal, in N.
    """

    link: int
    other: int
    depth_m: float
    up: float
    force: float


class Body:
    """A body in a physics client.

    Attributes:
        body_id: PyBullet's number of the body.
        physics_client_id: PyBullet's number of its physics client.
        client: That number as the keyword argument of each PyBullet call.
        fixed: Whether the root link never moves.
        links: Indices of the links, -1 for the base.
        link_indices: Index of each link by its name.
        joints: Index of each movable joint by its name.
        root: Name of the root link.
        name: Name of the model.
        is_terrain: Whether it is a heightmap, whose shape PyBullet does not tell.
        is_plane: Whether it is an infinite plane.
        was_moved: Whether it is fixed, and was moved from outside.
    """

    is_terrain = is_plane = was_moved = False

    def __init__(self, body_id: int, physics_client_id: int, fixed: bool = False):
        self.body_id, self.fixed = body_id, fixed
        self.physics_client_id, self.client = physics_client_id, client_argument(physics_client_id)
        self.set_defaults()
        self.links = range(-1, pybullet.getNumJoints(body_id, **self.client))
        self.link_indices = link_indices(body_id, physics_client_id)
        joints = (pybullet.getJointInfo(body_id, link, **self.client) for link in self.links[1:])
        self.joints: Dict[str, int] = {joint[1].decode(): joint[0] for joint in joints
                                       if joint[2] != pybullet.JOINT_FIXED}
        self.root, self.name = (
            name.decode() for name in pybullet.getBodyInfo(body_id, **self.client))
        self.mass_in_root = pybullet.getDynamicsInfo(body_id, -1, **self.client)[3:5]
        self._root_in_mass = pybullet.invertTransform(*self.mass_in_root)
        self.keep_as_start()

    def set_defaults(self) -> None:
        """Set what all bodies have in common; to be called after the body was loaded."""
        # of the whole body; in a call that sets something of a link, these would make PyBullet
        # set that of the root link
        pybullet.changeDynamics(self.body_id, -1, linearDamping=0, angularDamping=0,
                                maxJointVelocity=MAX_JOINT_VELOCITY, **self.client)

    @property
    def static_links(self) -> Set[int]:
        """Indices of the links that never move: a fixed base, and what fixed joints hold at it."""
        found = {-1} if self.fixed else set()
        for index in self.links[1:]:
            info = pybullet.getJointInfo(self.body_id, index, **self.client)
            if info[2] == pybullet.JOINT_FIXED and info[16] in found:
                found.add(index)
        return found

    def mass(self) -> float:
        """Return the mass of all links as PyBullet simulates them, in kg."""
        return sum(pybullet.getDynamicsInfo(self.body_id, link, **self.client)[0]
                   for link in self.links)

    def joint_values(self, joints: Optional[Sequence[int]] = None) -> Sequence[tuple]:
        """Return position, velocity, reaction forces and motor torque of joints.

        Args:
            joints: Indices of the joints, by default of all that move.
        """
        if joints is None:
            joints = tuple(self.joints.values())
        return pybullet.getJointStates(self.body_id, joints, **self.client) or ()

    def pose(self) -> BodyPose:
        """Return where the parts are now."""
        position, orientation = pybullet.multiplyTransforms(*self.center(), *self._root_in_mass)
        return BodyPose(position, orientation, [value[0] for value in self.joint_values()])

    def place(self, pose: BodyPose) -> None:
        """Move the parts to `pose`, at rest."""
        center = pybullet.multiplyTransforms(pose.position, pose.orientation, *self.mass_in_root)
        self.restore(BodyState(center, _REST, [(position, 0.0) for position in pose.joints]))

    def state(self) -> BodyState:
        """Return where the parts are and how they move, for `restore`."""
        return BodyState(self.center(), self.velocity(),
                         [(value[0], value[1]) for value in self.joint_values()])

    def center(self, part: int = -1) -> Tuple[Vector, Quaternion]:
        """Return the pose of the center of mass of a part in the world.

        Args:
            part: PyBullet's index of a link, -1 for the base.
        """
        return center(self.body_id, part, self.physics_client_id)

    def velocity(self, part: int = -1) -> Tuple[Vector, Vector]:
        """Return the velocity of the center of mass of a part: (3,) m/s and (3,) rad/s.

        Args:
            part: PyBullet's index of a link, -1 for the base.
        """
        if part == -1:
            return pybullet.getBaseVelocity(self.body_id, **self.client)
        return pybullet.getLinkState(self.body_id, part, computeLinkVelocity=1, **self.client)[6:8]

    def restore(self, state: BodyState) -> None:
        """Move the parts to a state."""
        pybullet.resetBasePositionAndOrientation(self.body_id, *state.center, **self.client)
        pybullet.resetBaseVelocity(self.body_id, *state.velocity, **self.client)
        for joint, values in zip(self.joints.values(), state.joints):
            pybullet.resetJointState(self.body_id, joint, *values, **self.client)

    def joint_state(self, joint: str) -> Tuple[float, float]:
        """Return position and velocity of a joint, in rad and rad/s or m and m/s."""
        state = pybullet.getJointState(self.body_id, self.joints[joint], **self.client)
        return state[0], state[1]

    def set_motor(self, joint: str, velocity: float, limit: float) -> None:
        """Let a motor hold a joint at a velocity in rad/s or m/s, with at most `limit` N m or N.
        """
        pybullet.setJointMotorControl2(
            self.body_id, self.joints[joint], pybullet.VELOCITY_CONTROL, force=limit,
            targetVelocity=max(-MAX_JOINT_VELOCITY, min(velocity, MAX_JOINT_VELOCITY)),
            **self.client)

    def set_joint(self, joint: str, position: float) -> None:
        """Put a joint at a position in rad or m, at rest."""
        pybullet.resetJointState(self.body_id, self.joints[joint], position, 0.0, **self.client)

    def raise_by(self, height: float) -> None:
        """Move the body upward by a height in m, without changing how it moves."""
        ((x, y, z), turned), velocity = self.center(), self.velocity()
        pybullet.resetBasePositionAndOrientation(self.body_id, (x, y, z + height), turned,
                                                 **self.client)
        pybullet.resetBaseVelocity(self.body_id, *velocity, **self.client)

    def reset(self) -> None:
        """Move the parts back to their start, at rest: to the last bit, which `place` rounds."""
        self.restore(self._start)

    def keep_as_start(self) -> None:
        """Let `reset` move the parts to where they are now; that is where they were loaded."""
        self._start = self.state().at_rest()
        self.restore(self._start)       # PyBullet rounds an orientation when it is set

    def motion(self) -> Motion:
        """Return the motion of the root link's frame."""
        return motion_of_frame(*self.part_state(-1, self._root_in_mass))

    def speed(self) -> float:
        """Return the speed of the center of mass of the root link, in m/s."""
        return math.hypot(*self.velocity()[0])

    def in_part(self, part: int, pose: Transform) -> Tuple[Vector, Quaternion]:
        """Return a constant pose in the frame of a part as `part_state` takes it.

        part: PyBullet's index of a link, -1 for the base, whose frame there is its center of mass.
        """
        in_link = pose.translation.tolist(), rotations.quaternion_of(pose.rotation)
        return in_link if part != -1 else pybullet.multiplyTransforms(
            *self._root_in_mass, *in_link)

    def part_state(self, part: int, in_part: Tuple[Vector, Quaternion]) -> FrameState:
        """Return the state of a frame fixed to a part; arguments: see `in_part`."""
        if part == -1:
            center = self.center()
            return FrameState(pybullet.multiplyTransforms(*center, *in_part), center[0],
                              *self.velocity())
        state = pybullet.getLinkState(self.body_id, part, computeLinkVelocity=1,
                                      computeForwardKinematics=1, **self.client)
        return FrameState(pybullet.multiplyTransforms(*state[4:6], *in_part), state[0],
                          *state[6:8])

    def contacts(self, detect: bool = False) -> List[ContactPoint]:
        """Return the contacts of the body in the last step of the physics.

        detect: look for those of where the bodies are now instead.
        """
        if detect:
            pybullet.performCollisionDetection(**self.client)
        # of two robots, either may be the first body of a contact
        return [ContactPoint(*((point[4], point[1]) if point[2] == self.body_id
                               else (point[3], point[2])), -point[8], point[7][2], point[9])
                for point in pybullet.getContactPoints(self.body_id, **self.client)]

    def set_velocity(self, linear: Vector, angular: Vector) -> None:
        """Set the velocity of the root link: m/s and rad/s, in the world."""
        arm = np.subtract(self.center()[0], self.pose().position)
        at_center = np.array(linear) + np.cross(angular, arm)
        pybullet.resetBaseVelocity(self.body_id, at_center.tolist(), list(angular), **self.client)


def relative(position: Vector, orientation: Quaternion, origin: Vector,
             turned: Quaternion) -> Tuple[Vector, Quaternion]:
    """Return a pose as seen from another one, `origin` and `turned`."""
    return pybullet.multiplyTransforms(*pybullet.invertTransform(origin, turned), position,
                                       orientation)


def velocity_at(position: Vector, point: Vector, linear: Vector, angular: Vector) -> Vector:
    """Return the velocity of a position that moves with a rigid part; all in the world.

    point: any point of the part, and linear: the velocity of that point; angular: the angular
    velocity of the part.
    """
    (px, py, pz), (x0, y0, z0) = position, point
    x, y, z = px - x0, py - y0, pz - z0
    (vx, vy, vz), (wx, wy, wz) = linear, angular
    return vx + wy * z - wz * y, vy + wz * x - wx * z, vz + wx * y - wy * x


def motion_of_frame(frame: Tuple[Vector, Quaternion], point: Vector, linear: Vector,
                    angular: Vector) -> Motion:
    """Return the motion of a frame fixed to a rigid part.

    frame: position and orientation in the world; the others as for `velocity_at`.
    """
    position, orientation = frame
    at_frame = velocity_at(position, point, linear, angular)
    return Motion(np.array(position), orientation,
                  *np.array(rotations.into_frame(orientation, at_frame, angular)))
