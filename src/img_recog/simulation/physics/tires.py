"""Treads: the edges with which a wheel touches the floor.

A cylinder on a plane touches it with both edges in Gazebo, or with the lower one where its axle
leans. PyBullet finds one or the other in a step, whichever is lower by a hair. So a wheel gets a
link with a narrow tread at each edge that touches. The treads touch only what never moves, and the
whole cylinder touches everything except floors, see collision_filters.py. A wheel that is a mesh
becomes a cylinder: the convex hull of PyBullet has corners, and is 1 mm larger. ODE pushes a wheel
out of the floor from a depth of <min_depth> on, so the rest of its robot is lower by that depth.
"""
import dataclasses
import itertools
from typing import Collection, Iterator, List

import numpy as np

from img_recog.model import (ALL_BITS, CONTINUOUS, CYLINDER, FIXED, MESH, PART, REVOLUTE, SPHERE,
                             Contact, Joint, Link, Model, Shape, Solid)
from img_recog.rotations import IDENTITY, Transform
from img_recog.simulation.wheels import mesh_outline, pose_in_root

TREAD = '::tread_'      # in the name of a link with a tread, between the wheel's name and a number
ACROSS = '_across'      # at the end of the second one, if there is a direction of friction
_TREAD_M = 0.002
_TURNING = CONTINUOUS, REVOLUTE
_MIN_LEAN = 1e-4        # rad, of an axle: from there on, only the lower edge of two wheels touches
# In ODE, joints give way a little under the load, and more than two wheels that do not lean stand
# on their outer edges. A hair is enough for that.
_HIGHER_M = 2e-6        # height of the inner edge above the floor
_PARALLEL = 0.99
# highest <min_depth> that counts, and the depth to which a wheel sinks without it
_MAX_SLACK_M, _GIVES_WAY_M = 0.005, 0.0005
_GRAVITY_M_S2, _STEP_S = 9.81, 0.001        # Gazebo's defaults


def added(model: Model, driven: Collection[str] = ()) -> Model:
    """Return a model with treads on each link that is round about the joint that turns it.

    Args:
        driven: Names of the joints of wheels. A wheel can also be a round mesh.
    """
    links = {link.name: link for link in model.links}
    joints: List[Joint] = []
    # the joints of more wheels give way so much in ODE that an axle that leans is like others
    many = _wheel_count(model) > 2
    for joint in model.joints:
        joints.append(joint)
        if joint.kind in _TURNING:
            wheel, axis = links[joint.child], np.asarray(joint.axis)
            if wheel.solids and all(_is_round(solid, axis) for solid in wheel.solids):
                joints[-1] = _lower_than(wheel, joint)
            if joint.name in driven:
                wheel = wheel._replace(solids=tuple(_round(solid, axis) for solid in wheel.solids))
                links[joint.child] = wheel
            pose = pose_in_root(joint, model)
            is_lower = many and not leans(wheel, model)
            treads = [tread for solid in wheel.solids
                      for tread in _treads(solid, joint, pose, many, is_lower)]
            for (number, tread), end in itertools.product(
                    enumerate(treads), ('', ACROSS) if wheel.surface.direction else ('',)):
                # a link each: PyBullet computes the contacts of one link in any order
                name = '{}{}{}{}'.format(joint.child, TREAD, number, end)
                links[name] = Link(name, solids=(tread,), space=wheel.space)
                joints.append(Joint(name, FIXED, joint.child, name))
    return dataclasses.replace(model, links=tuple(links.values()), joints=tuple(joints))


def leans(wheel: Link, model: Model) -> bool:
    """Return whether a wheel leans so fast in ODE that it stays on the floor.

    ODE does not solve the joint of a wheel completely in a step. The friction at the lower edge of
    the wheel tilts it, and the load on this edge tilts it back. If the edge then goes down faster
    than a contact pushes it out, the wheel does not leave the floor. The loads of three wheels
    depend only on where they are, so it does not matter there.

    Args:
        wheel: Link of the wheel, a cylinder.
        model: Model of the wheel, with or without treads.
    """
    count = _wheel_count(model)
    sizes = [solid.shape.size for solid in wheel.solids if solid.shape.kind == CYLINDER]
    if count < 4 or wheel.inertia is None or not sizes:
        return False
    radius, length = sizes[0]
    load = _GRAVITY_M_S2 / count * sum(
        link.inertia.mass for link in model.links if link.inertia is not None)
    moment = np.linalg.eigvalsh(wheel.inertia.matrix)[1]        # across the axle
    return bool(load * (radius - length / 2) * length / 2 * _STEP_S > moment * Contact().fastest)


def _wheel_count(model: Model) -> int:
    turning = {joint.child for joint in model.joints if joint.kind in _TURNING}
    return sum(any(solid.shape.kind in (CYLINDER, MESH) for solid in link.solids)
               for link in model.links if link.name in turning)


def _lower_than(wheel: Link, joint: Joint) -> Joint:
    """Return the joint of a wheel with its parent lower by the <min_depth> of the wheel."""
    height_m = min(wheel.solids[0].contact.slack, _MAX_SLACK_M) - _GIVES_WAY_M
    return joint._replace(pose=joint.pose._replace(
        translation=joint.pose.translation + (0.0, 0.0, max(height_m, 0.0))))


def owner(link: str) -> str:
    """Return the name of the link of the file to which the solids of a link in PyBullet belong."""
    return wheel_of(link).partition(PART)[0]


def wheel_of(link: str) -> str:
    """Return the name of the wheel of a link with a tread, otherwise the name of the link."""
    return link.partition(TREAD)[0]


def _is_round(solid: Solid, axis: np.ndarray) -> bool:
    """Return whether a solid is a sphere, or a cylinder along an axis (3,), a unit vector."""
    return solid.shape.kind == SPHERE or (
        solid.shape.kind == CYLINDER and abs(solid.pose.rotation[:, 2] @ axis) > _PARALLEL)


def _round(solid: Solid, axis: np.ndarray) -> Solid:
    """Return a cylinder in place of a mesh that is round about an axis, otherwise the solid."""
    outline = mesh_outline(solid, axis)
    if outline is None or outline.diameter is None:
        return solid
    return solid._replace(shape=Shape(CYLINDER, (outline.diameter / 2, outline.width)),
                          pose=Transform(_along(axis), outline.middle))


def _along(axis: np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) that turns z to an axis."""
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    return np.column_stack((np.cross(across, axis), across, axis))


def _treads(solid: Solid, joint: Joint, pose: Transform, many: bool,
            is_lower: bool) -> Iterator[Solid]:
    """Yield the treads of a cylinder along the axis of its joint: both, or the lower one.

    A cylinder with a bitmask has none: the bits that keep a wheel and a floor apart are taken.

    Args:
        pose: Pose of the wheel in the root link.
        many: Whether the robot has more than two wheels.
        is_lower: Whether the outer tread is lower than the inner one.
    """
    axis = np.asarray(joint.axis)
    if (solid.shape.kind != CYLINDER or solid.shape.size[1] <= _TREAD_M
            or not _is_round(solid, axis) or solid.bitmask != ALL_BITS):
        return
    radius, length = solid.shape.size
    rise = (joint.pose.rotation @ solid.pose.rotation[:, 2])[2]
    edges = [solid.pose @ IDENTITY._replace(
        translation=np.array((0.0, 0.0, end * (length - _TREAD_M) / 2)))
        for end in (1, -1) if many or end * rise < _MIN_LEAN]
    away = [abs(float((pose.rotation @ axis) @ (pose @ edge).translation)) for edge in edges]
    for edge, distance in zip(edges, away):
        is_lowest = not is_lower or distance > max(away) - _TREAD_M
        yield solid._replace(shape=solid.shape._replace(size=(
            radius if is_lowest else radius - _HIGHER_M, _TREAD_M)), pose=edge)
