"""Tyres: what a robot needs for its wheels to touch and to slip in PyBullet as they should.

A wide cylinder on a plane touches it with one edge or the other, whichever is lower by a hair.
Then wheels are farther apart than they look, or nearer, and the load is anywhere. So a driven
wheel has a narrow tread in its middle, and the rest of it does not reach the floor. A wheel that
is a mesh becomes a cylinder: the convex hull of PyBullet has corners, and is 1 mm larger.

Where a contact slips, PyBullet's friction does not point against the slip: each of its two
directions is weighted with the mass that moves along it (btMultiBodyConstraintSolver scales each
row by its effective mass, and then limits the length). Along the floor, a wheel that turns on its
axle is light; sideways it moves the whole robot. Nearly all of the friction would be sideways, and
hold a skid-steered robot that tries to turn. So a wheel that slips has a joint along its axle,
which a motor keeps in place: only the mass of the wheel counts sideways then. It also gets as much
inertia.
"""
import dataclasses
from typing import Collection, List, Sequence, Tuple

import numpy as np

from img_recog.model import (CYLINDER, FIXED, NO_INERTIA, PRISMATIC, Inertia, Joint, Limits, Link,
                             Model, Shape, Solid)
from img_recog.rotations import IDENTITY, Transform
from img_recog.simulation.physics.wheels import axis_of, mesh_outline

SUFFIX = '/tyre'        # of the joints and links that are added
_TREAD_M = 0.002
_MIN_WIDTH_M = 0.02     # of wheels that have a tread in any case
_MIN_LEAN = 1e-4        # rad
# what is nearer to the floor makes contacts (the breaking threshold of Bullet), which take time
_CLEARANCE_M = 0.0201
_PARALLEL = 0.99
_SHARE = 0.1            # of the mass of a wheel: that of the link between it and the robot
_GYRATION_M2 = 1e-3     # inertia of that link for its mass
_LIMITS = Limits(-1.0, 1.0, 1e6, 1e3)     # m; never reached


_Wheels = Sequence[Tuple[Joint, Link]]      # with the joints that turn them


def added(model: Model, joints: Collection[str], slip_radius: float) -> Model:
    """Return a robot with tyres for its wheels, given by their joints.

    slip_radius: of the wheels in m if they slip when the robot turns, else 0.
    """
    links = {link.name: link for link in model.links}
    turning = [joint for joint in model.joints if joint.name in joints and joint.kind != FIXED]
    for joint in turning:
        wheel = links[joint.child]
        links[joint.child] = wheel._replace(
            solids=tuple(_round(solid, axis_of(joint)) for solid in wheel.solids))
    wheels = [(joint, links[joint.child]) for joint in turning]
    min_width = _MIN_WIDTH_M if _lean_alike(wheels) else _TREAD_M
    sides: List[Joint] = []
    for joint, wheel in wheels:
        solids = [_without_edges(solid, axis_of(joint), min_width) for solid in wheel.solids]
        treads = [solid._replace(shape=solid.shape._replace(size=(solid.shape.size[0], _TREAD_M)))
                  for solid, narrow in zip(wheel.solids, solids) if narrow is not solid]
        links[wheel.name] = wheel._replace(solids=(*solids, *treads))
        if slip_radius:
            sides.append(_side_joint(joint))
            between, links[wheel.name] = _shared(links[wheel.name], sides[-1].child, slip_radius)
            links[between.name] = between
    slipping = {side.child for side in sides}
    hung = [joint._replace(parent=joint.name + SUFFIX, pose=IDENTITY)
            if joint.name + SUFFIX in slipping else joint for joint in model.joints]
    return dataclasses.replace(model, links=tuple(links.values()), joints=(*hung, *sides))


def _lean_alike(wheels: _Wheels) -> bool:
    """Return whether all wheels, given with their joints, lean to the same side.

    Then they touch the floor with the edges of the same side, and are as far apart as they look:
    the axles of the burger, by rpy 1.57, slope by 0.0008 rad.
    """
    axles = [joint.pose.rotation @ axis_of(joint) for joint, _ in wheels]
    leans = [axle[2] * np.sign(axle @ axles[0]) for axle in axles]
    return bool(leans) and (min(leans) > _MIN_LEAN or max(leans) < -_MIN_LEAN) and all(
        abs(solid.pose.rotation[:, 2] @ axis_of(joint)) > 1 - _MIN_LEAN ** 2
        for joint, wheel in wheels for solid in wheel.solids)


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


def _without_edges(solid: Solid, axis: np.ndarray, min_width: float) -> Solid:
    """Return a cylinder about the axis that is wider than `min_width` so that it does not reach
    the floor beside its tread; other solids as they are.
    """
    if (solid.shape.kind != CYLINDER or solid.shape.size[1] <= min_width
            or abs(solid.pose.rotation[:, 2] @ axis) <= _PARALLEL):
        return solid
    radius, length = solid.shape.size
    return solid._replace(shape=solid.shape._replace(
        size=(max(radius - _CLEARANCE_M, radius / 2), length)))


def _side_joint(joint: Joint) -> Joint:
    """Return the joint that comes between the robot and a wheel."""
    name = joint.name + SUFFIX
    return Joint(name, PRISMATIC, joint.parent, name, joint.pose, axis_of(joint), _LIMITS)


def _shared(wheel: Link, name: str, radius: float) -> Tuple[Link, Link]:
    """Return a link that carries a part of a wheel's mass, and the wheel without that."""
    mass, pose, matrix = wheel.inertia or NO_INERTIA
    between = Inertia(mass * _SHARE, IDENTITY, mass * _SHARE * _GYRATION_M2 * np.eye(3))
    # the same to all moments, so that it stays the inertia of a body
    missing = max(0.0, mass * radius ** 2 - float(matrix.diagonal().min()))
    return Link(name, between), wheel._replace(
        inertia=Inertia(mass * (1 - _SHARE), pose, matrix + missing * np.eye(3)))
