"""Tyres: where a wheel touches the floor.

A cylinder on a plane touches it with both edges in Gazebo, or with the lower one where its axle
leans. PyBullet finds one or the other, whichever is lower by a hair: then wheels are farther apart
than they look, or nearer, and the load is anywhere. So a wheel has a narrow tread at each edge
that touches, and the rest of it does not reach the floor. A wheel that is a mesh becomes a
cylinder: the convex hull of PyBullet has corners, and is 1 mm larger. One with a direction of
friction has all of that twice, see directions.py. By what a wheel sinks into the floor before that
pushes it out (<min_depth>), the rest of its robot is lower.
"""
import dataclasses
from typing import Collection, Iterator, List

import numpy as np

from img_recog.model import (CONTINUOUS, CYLINDER, FIXED, PART, REVOLUTE, SPHERE, Joint, Link,
                             Model, Shape, Solid)
from img_recog.rotations import IDENTITY, Transform
from img_recog.simulation.physics.wheels import mesh_outline

ACROSS = '::across'     # in the name of the second link of a wheel
_TREAD_M = 0.002
_MIN_LEAN = 1e-4        # rad, of an axle: ODE's tolerance
# what is nearer to the floor makes contacts (the breaking threshold of Bullet), which take time
_CLEARANCE_M = 0.0201
_PARALLEL = 0.99
# of the depth from which a wheel is pushed out; what it sinks in by itself, see stiffness.py
_MAX_SLACK_M, _GIVES_WAY_M = 0.005, 0.0005


def added(model: Model, driven: Collection[str] = ()) -> Model:
    """Return a model with tyres for all that is round about the joint that turns it.

    driven: the joints of wheels, which are round also if they are meshes.
    """
    links = {link.name: link for link in model.links}
    joints: List[Joint] = []
    for joint in model.joints:
        joints.append(joint)
        if joint.kind in (CONTINUOUS, REVOLUTE):
            wheel, axis = links[joint.child], np.asarray(joint.axis)
            if wheel.solids and all(_is_round(solid, axis) for solid in wheel.solids):
                joints[-1] = _lower_than(wheel, joint)
            solids = [_round(solid, axis) for solid in wheel.solids
                      ] if joint.name in driven else wheel.solids
            links[joint.child] = wheel._replace(
                solids=tuple(part for solid in solids for part in _shod(solid, joint)))
            if wheel.surface.direction and all(_is_round(solid, axis) for solid in solids):
                second = joint.child + ACROSS
                links[second] = Link(second, solids=tuple(
                    tread for solid in solids for tread in _treads(solid, joint)),
                    space=wheel.space)
                joints.append(Joint(second, FIXED, joint.child, second))
    return dataclasses.replace(model, links=tuple(links.values()), joints=tuple(joints))


def _lower_than(wheel: Link, joint: Joint) -> Joint:
    """Return the joint of a wheel with its parent as much lower as the wheel sinks into a floor.
    """
    height_m = min(wheel.solids[0].contact.slack, _MAX_SLACK_M) - _GIVES_WAY_M
    return joint._replace(pose=joint.pose._replace(
        translation=joint.pose.translation + (0.0, 0.0, max(height_m, 0.0))))


def owner(link: str) -> str:
    """Return the name of the link of the file of whose solids a link of PyBullet has some."""
    return link.replace(ACROSS, '').partition(PART)[0]


def _is_round(solid: Solid, axis: np.ndarray) -> bool:
    """Return whether a solid is a sphere, or a cylinder along an axis (3,), a unit vector."""
    return solid.shape.kind == SPHERE or (
        solid.shape.kind == CYLINDER and abs(solid.pose.rotation[:, 2] @ axis) > _PARALLEL)


def _round(solid: Solid, axis: np.ndarray) -> Solid:
    """Return a cylinder in place of a mesh that is round about an axis, else the solid."""
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


def _shod(solid: Solid, joint: Joint) -> Iterator[Solid]:
    """Yield a cylinder about the axis of its joint without what reaches the floor beside its
    treads, and those; other solids as they are.
    """
    for number, tread in enumerate(_treads(solid, joint)):
        if number == 0 and tread is not solid:
            radius, length = solid.shape.size
            yield solid._replace(shape=solid.shape._replace(
                size=(max(radius - _CLEARANCE_M, radius / 2), length)))
        yield tread


def _treads(solid: Solid, joint: Joint) -> Iterator[Solid]:
    """Yield those of a cylinder about the axis of its joint; other solids as they are."""
    if (solid.shape.kind != CYLINDER or solid.shape.size[1] <= _TREAD_M
            or not _is_round(solid, np.asarray(joint.axis))):
        yield solid
        return
    radius, length = solid.shape.size
    rise = (joint.pose.rotation @ solid.pose.rotation[:, 2])[2]
    for end in (1, -1):
        if end * rise < _MIN_LEAN:
            middle = IDENTITY._replace(
                translation=np.array((0.0, 0.0, end * (length - _TREAD_M) / 2)))
            yield solid._replace(shape=solid.shape._replace(size=(radius, _TREAD_M)),
                                 pose=solid.pose @ middle)
