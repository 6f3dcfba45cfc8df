"""Elements of a URDF that several modules read or write: origins, inertias and friction."""
import xml.etree.ElementTree as ElementTree
from typing import List

import numpy as np

from img_recog import rotations
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform, from_rpy
from img_recog.simulation.descriptions.numbers import read_lengths, read_numbers, words
from img_recog.simulation.descriptions.texts import name_of
from img_recog.simulation.settings import SimulationError

INERTIA_KEYS = ('ixx', 'ixy', 'ixz', 'ixy', 'iyy', 'iyz', 'ixz', 'iyz', 'izz')   # row by row
# kg: in PyBullet, a body of 1e300 kg falls through the floor
_MIN_MASS, _MAX_MASS = 1e-20, 1e9


def roots(robot: ElementTree.Element) -> List[str]:
    """Return the names of the links that are the child of no joint."""
    children = {child.get('link') for child in robot.findall('joint/child')}
    return [name_of(link) for link in robot.findall('link')
            if link.get('name') not in children]


def origin_of(element: ElementTree.Element) -> Transform:
    """Return the <origin> of a URDF's element: its pose in the frame of what it belongs to."""
    origin = element.find('origin')
    if origin is None:
        return IDENTITY
    name = '<origin> in <{} {}>'.format(element.tag, name_of(element))
    return from_rpy(read_lengths(name, origin.get('xyz', '0 0 0'), 3),
                    read_numbers(name, origin.get('rpy', '0 0 0'), 3))


def set_origin(element: ElementTree.Element, pose: Transform) -> None:
    """Give an element an <origin> in place of the one that it may have."""
    for old in element.findall('origin'):
        element.remove(old)
    ElementTree.SubElement(element, 'origin', xyz=words(pose.translation),
                           rpy=words(rotations.to_rpy(pose.rotation)))


def set_inertial(link: ElementTree.Element, mass: float, pose: Transform,
                 matrix: np.ndarray) -> None:
    """Give a link an <inertial> in place of the one that it may have.

    mass: kg; pose: of the center of mass in the link's frame; matrix (3, 3): the inertia about
    that center in kg m2.
    """
    for old in link.findall('inertial'):
        link.remove(old)
    inertial = ElementTree.SubElement(link, 'inertial')
    set_origin(inertial, pose)
    ElementTree.SubElement(inertial, 'mass', value=repr(float(mass)))
    ElementTree.SubElement(inertial, 'inertia', {
        key: repr(float(value)) for key, value in zip(INERTIA_KEYS, matrix.flat)})


def add_massless(link: ElementTree.Element) -> None:
    """Add the inertia of what never moves: without it, PyBullet warns and assumes 1 kg."""
    inertial = ElementTree.SubElement(link, 'inertial')
    ElementTree.SubElement(inertial, 'mass', value='0')
    ElementTree.SubElement(inertial, 'inertia', dict.fromkeys(INERTIA_KEYS, '0'))


def set_friction(link: ElementTree.Element, value: float) -> None:
    """Give a link a coefficient of friction in place of the one that it may have."""
    contact = link.find('contact')
    if contact is None:
        contact = ElementTree.SubElement(link, 'contact')
    for old in contact.findall('lateral_friction'):
        contact.remove(old)
    ElementTree.SubElement(contact, 'lateral_friction', value=repr(value))


def check_mass(name: str, mass: float, otherwise: str = '') -> None:
    """Raise SimulationError unless a mass in kg can be used; otherwise: what else is allowed.

    >>> check_mass('mass of link a', 0.0)
    Traceback (most recent call last):
    img_recog.simulation.settings.SimulationError: mass of link a: got 0 kg, expected more than 0
    """
    if not _MIN_MASS <= mass <= _MAX_MASS:
        limit = 'more than 0' if mass < _MIN_MASS else 'at most {:g}'.format(_MAX_MASS)
        raise SimulationError('{}: got {:g} kg, expected {}{}'.format(
            name, mass, limit, otherwise))
