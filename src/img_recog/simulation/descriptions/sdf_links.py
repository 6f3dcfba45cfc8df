"""The masses and friction of the links of an SDF, as elements of a URDF."""
import xml.etree.ElementTree as ElementTree

import numpy as np

from img_recog.simulation.descriptions import inertias, sdf_shapes
from img_recog.simulation.descriptions.geometry import Transform
from img_recog.simulation.descriptions.numbers import read_coefficient, read_numbers
from img_recog.simulation.descriptions.sdf_frames import pose_of

_INERTIA_KEYS = ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz')


def add_massless(link: ElementTree.Element) -> None:
    """Add the inertia of what never moves: without it, PyBullet warns and assumes 1 kg."""
    inertial = ElementTree.SubElement(link, 'inertial')
    ElementTree.SubElement(inertial, 'mass', value='0')
    ElementTree.SubElement(inertial, 'inertia', dict.fromkeys(_INERTIA_KEYS, '0'))


def add_inertial(link: ElementTree.Element, source: ElementTree.Element,
                 offset: Transform) -> None:
    """Add the inertia of an SDF's link; offset: of that in the frame of the URDF's link."""
    name = source.get('name', '')
    given = source.find('inertial')
    if given is None:
        given = ElementTree.Element('inertial')
    mass = float(read_numbers('<mass> of link ' + name, given.findtext('mass', '1'), 1)[0])
    inertias.check_mass('<mass> of link ' + name, mass)
    values = {key: float(read_numbers(
        '<{}> of link {}'.format(key, name),
        given.findtext('inertia/' + key, '1' if key[1] == key[2] else '0'), 1)[0])
        for key in _INERTIA_KEYS}
    inertias.check_moments('link ' + name, np.array([
        [values[''.join(sorted(('i', row, column)))] for column in 'xyz'] for row in 'xyz']))
    inertial = ElementTree.SubElement(link, 'inertial')
    inertial.append(sdf_shapes.origin(offset @ pose_of(given)))
    ElementTree.SubElement(inertial, 'mass', value=repr(mass))
    ElementTree.SubElement(inertial, 'inertia',
                           {key: repr(value) for key, value in values.items()})


def add_friction(link: ElementTree.Element, source: ElementTree.Element) -> None:
    """Add the coefficient of the first collision that has one: PyBullet has one for each link."""
    text = source.findtext('collision/surface/friction/ode/mu')
    if text is None:
        return
    name = '<mu> of link ' + source.get('name', '')
    value = read_coefficient(name, text)
    contact = ElementTree.SubElement(link, 'contact')
    ElementTree.SubElement(contact, 'lateral_friction', value=repr(value))
