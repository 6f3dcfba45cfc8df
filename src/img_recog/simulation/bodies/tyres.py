"""Tyres: what a URDF needs for its wheels to touch and to slip in PyBullet as they should.

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
import copy
import xml.etree.ElementTree as ElementTree
from typing import Collection, Dict, Sequence, Tuple

import numpy as np

from img_recog.simulation.descriptions import urdf_tree
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform
from img_recog.simulation.descriptions.numbers import words
from img_recog.simulation.descriptions.urdf_elements import origin_of, set_origin
from img_recog.simulation.descriptions.urdf_tree import Joint
from img_recog.simulation.descriptions.wheels import axis_of, mesh_outline

SUFFIX = '/tyre'        # of the joints and links that are added
_TREAD_M = 0.002
_MIN_WIDTH_M = 0.02     # of wheels that have a tread in any case
_MIN_LEAN = 1e-4        # rad
# what is nearer to the floor makes contacts (the breaking threshold of Bullet), which take time
_CLEARANCE_M = 0.0201
_PARALLEL = 0.99
_SHARE = 0.1            # of the mass of a wheel: that of the link between it and the robot
_GYRATION_M2 = 1e-3     # inertia of that link for its mass
_LIMIT_M = '1'          # is never reached


def added(urdf: str, joints: Collection[str], slip_radius: float) -> str:
    """Return the text of a URDF with tyres for its wheels, given by their joints.

    slip_radius: of the wheels in m if they slip when the robot turns, else 0.
    """
    robot = ElementTree.fromstring(urdf)
    tree = urdf_tree.read(robot)
    wheels = [(joint, tree.links[link]) for link, joint in tree.parents.items()
              if joint.name in joints]
    for joint, wheel in wheels:
        for shape in wheel.findall('collision'):
            _make_round(shape, axis_of(joint.element))
    min_width = _MIN_WIDTH_M if _lean_alike(wheels) else _TREAD_M
    for joint, wheel in wheels:
        for shape in wheel.findall('collision'):
            _add_tread(wheel, shape, axis_of(joint.element), min_width)
        if slip_radius:
            robot.extend(_side_joint(joint, wheel, slip_radius))
    return ElementTree.tostring(robot, 'unicode')


def _lean_alike(wheels: Sequence[Tuple[Joint, ElementTree.Element]]) -> bool:
    """Return whether all wheels, given with their joints, lean to the same side.

    Then they touch the floor with the edges of the same side, and are as far apart as they look:
    the axles of the burger, by rpy 1.57, slope by 0.0008 rad.
    """
    axles = [origin_of(joint.element).rotation @ axis_of(joint.element) for joint, _ in wheels]
    leans = [axle[2] * np.sign(axle @ axles[0]) for axle in axles]
    return bool(leans) and (min(leans) > _MIN_LEAN or max(leans) < -_MIN_LEAN) and all(
        abs(origin_of(shape).rotation[:, 2] @ axis_of(joint.element)) > 1 - _MIN_LEAN ** 2
        for joint, wheel in wheels for shape in wheel.findall('collision'))


def _make_round(shape: ElementTree.Element, axis: np.ndarray) -> None:
    """Replace a mesh that is round about an axis by a cylinder."""
    outline = mesh_outline(shape, axis)
    geometry = shape.find('geometry')
    if outline is not None and outline.diameter is not None and geometry is not None:
        geometry.clear()
        ElementTree.SubElement(geometry, 'cylinder', radius=repr(outline.diameter / 2),
                               length=repr(outline.width))
        set_origin(shape, Transform(_along(axis), outline.middle))


def _along(axis: np.ndarray) -> np.ndarray:
    """Return a rotation (3, 3) that turns z to an axis."""
    across = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    across /= np.linalg.norm(across)
    return np.column_stack((np.cross(across, axis), across, axis))


def _add_tread(wheel: ElementTree.Element, shape: ElementTree.Element, axis: np.ndarray,
               min_width: float) -> None:
    """Give a wheel a tread if a shape of it is a cylinder about the axis, wider than `min_width`.
    """
    cylinder = shape.find('geometry/cylinder')
    if cylinder is None or float(cylinder.attrib['length']) <= min_width:
        return
    if abs(origin_of(shape).rotation[:, 2] @ axis) > _PARALLEL:
        tread = copy.deepcopy(shape)
        tread.find('geometry/cylinder').set('length', repr(_TREAD_M))    # type: ignore
        wheel.append(tread)
        radius = float(cylinder.attrib['radius'])
        cylinder.set('radius', repr(max(radius - _CLEARANCE_M, radius / 2)))


def _side_joint(joint: Joint, wheel: ElementTree.Element, radius: float
                ) -> Collection[ElementTree.Element]:
    """Return a link and a joint that come between a wheel and the robot."""
    name = joint.name + SUFFIX
    mass, inertia = wheel.find('inertial/mass'), wheel.find('inertial/inertia')
    if mass is None or inertia is None:
        return ()
    kilograms = float(mass.attrib['value'])
    mass.set('value', repr(kilograms * (1 - _SHARE)))
    _add_inertia(inertia, kilograms * radius ** 2)
    link = ElementTree.fromstring(
        '<link name="{0}"><inertial><mass value="{1!r}"/><inertia ixx="{2!r}" ixy="0" ixz="0" '
        'iyy="{2!r}" iyz="0" izz="{2!r}"/></inertial></link>'.format(
            name, kilograms * _SHARE, kilograms * _SHARE * _GYRATION_M2))
    side = ElementTree.fromstring(
        '<joint name="{0}" type="prismatic"><parent link="{1}"/><child link="{0}"/>'
        '<axis xyz="{2}"/><limit lower="-{3}" upper="{3}" effort="1e6" velocity="1e3"/>'
        '</joint>'.format(name, joint.parent_link, words(axis_of(joint.element)), _LIMIT_M))
    set_origin(side, origin_of(joint.element))
    joint.parent.set('link', name)
    set_origin(joint.element, IDENTITY)
    return link, side


def _add_inertia(inertia: ElementTree.Element, wanted: float) -> None:
    """Make all moments of inertia at least `wanted` kg m2."""
    moments: Dict[str, float] = {key: float(inertia.attrib[key]) for key in ('ixx', 'iyy', 'izz')}
    # the same to all, so that it stays the inertia of a body
    missing = max(0.0, wanted - min(moments.values()))
    for key, moment in moments.items():
        inertia.set(key, repr(moment + missing))
