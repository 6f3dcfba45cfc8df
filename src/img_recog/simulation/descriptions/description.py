"""Prepares a robot description (URDF) for PyBullet.

PyBullet gives a link without <inertial> a mass of 1 kg, and every fixed joint costs time in each
step. Therefore fixed links are lumped into the link that they are fixed to, like Gazebo's
SDFormat does: shapes are moved, masses and inertias added up, and `frames` keeps where each link
went. A fixed link with a mass and a friction coefficient stays, since PyBullet has one coefficient
per link.
"""
import os
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from typing import Dict, NamedTuple, Sequence

import numpy as np

from img_recog.files import FindFile, find_in
from img_recog.markup import MarkupError, parse_xml
from img_recog.simulation.descriptions import urdf_visuals
from img_recog.simulation.descriptions.geometry import IDENTITY, NO_INERTIA, Inertia, Transform
from img_recog.simulation.descriptions.meshes import resolve
from img_recog.simulation.descriptions.numbers import (read_coefficient, read_direction,
                                                       read_number, read_numbers)
from img_recog.simulation.descriptions.urdf_elements import (
    INERTIA_KEYS, check_mass, check_moments, origin_of, set_inertial, set_origin)
from img_recog.simulation.settings import SimulationError

# Of the floor, and of links without a coefficient (Gazebo's default). PyBullet multiplies the
# coefficients of two bodies, Gazebo takes the lower one: a higher one makes no difference there.
FLOOR_FRICTION = 1.0
_JOINTS = ('continuous', 'fixed', 'prismatic', 'revolute')


@dataclass(frozen=True)
class Frame:
    """Where a link of the description went: its constant `pose` in the lumped `link`."""

    link: str
    pose: Transform


@dataclass(frozen=True)
class Description:
    """A lumped robot.

    name: of the robot; urdf: XML text for PyBullet; root: name of the root link; frames: of all
    links of the original description; friction: lateral friction coefficients of the lumped links
    that have one; missing_meshes: URIs of meshes that were not found; missing_materials: what is
    not known or not found of the materials in <gazebo> tags.
    """

    name: str
    urdf: str
    root: str
    frames: Dict[str, Frame]
    friction: Dict[str, float]
    missing_meshes: Sequence[str] = ()
    missing_materials: Sequence[str] = ()


class _Joint(NamedTuple):
    """A joint: its name, its element and the <parent> in it."""

    name: str
    element: ElementTree.Element
    parent: ElementTree.Element

    @property
    def parent_link(self) -> str:
        return self.parent.get('link', '')


def parse(urdf: str, find_mesh: FindFile = find_in(os.sep)) -> Description:
    """Read and lump a robot description.

    find_mesh: returns the path of a mesh's URI.
    Raises SimulationError when it is not a URDF, its links are not a tree, or a mass or another
    number cannot be simulated.
    """
    robot = root_of(urdf)
    _check_names(robot)
    missing = resolve(robot, find_mesh)
    missing_materials = urdf_visuals.apply_materials(robot, find_mesh)
    urdf_visuals.check_shapes(robot)
    links = {link.get('name', ''): link for link in robot.findall('link')}
    parents = _joints_by_child(robot, links)
    root = _root(links, parents)
    of_links = {name: _inertia(name, link) for name, link in links.items()}
    friction = {name: value for name, value in frictions(robot).items()
                if of_links[name].mass or not _is_fixed(name, parents)}
    frames = {name: _frame(name, parents, friction) for name in links}

    for name, frame in frames.items():
        if frame.link != name:
            _move_shapes(links[name], links[frame.link], frame.pose)
            of_links[frame.link] += of_links[name].moved(frame.pose)
            robot.remove(links[name])
    for child, joint in parents.items():
        if frames[child].link != child:
            robot.remove(joint.element)
        else:
            carrier = frames[joint.parent_link]
            joint.parent.set('link', carrier.link)
            set_origin(joint.element, carrier.pose @ origin_of(joint.element))
    for joint in parents.values():
        _check_joint(joint.element)
    for name in {frame.link for frame in frames.values()}:
        _set_inertia(name, links[name], of_links[name])
    return Description(robot.get('name') or 'robot', ElementTree.tostring(robot, 'unicode'), root,
                       frames, friction, tuple(missing), tuple(missing_materials))


def root_of(urdf: str) -> ElementTree.Element:
    """Return the <robot> of a URDF's text; SimulationError when it is not a URDF."""
    try:
        robot = parse_xml(urdf)
    except MarkupError as error:
        raise SimulationError(error.problem, error.advice or 'check the file given as urdf')
    if robot.tag != 'robot':
        raise SimulationError('got the root element <{}>, expected <robot> (URDF)'.format(
            robot.tag))
    return robot


def _check_names(robot: ElementTree.Element) -> None:
    for tag in ('link', 'joint'):
        names = [element.get('name') for element in robot.findall(tag)]
        if None in names or len(set(names)) < len(names):
            raise SimulationError('each <{}> must have a unique name (names: {})'.format(
                tag, ', '.join(map(str, names))))


def _joints_by_child(robot: ElementTree.Element,
                     links: Dict[str, ElementTree.Element]) -> Dict[str, _Joint]:
    joints: Dict[str, _Joint] = {}
    for joint in robot.findall('joint'):
        name = joint.get('name', '')
        parent, child = (_end(joint, end, links) for end in ('parent', 'child'))
        link = child.get('link', '')
        if link in joints:
            raise SimulationError('link {} is the child of two joints, {} and {}'.format(
                link, joints[link].name, name))
        joints[link] = _Joint(name, joint, parent)
    return joints


def _end(joint: ElementTree.Element, end: str,
         links: Dict[str, ElementTree.Element]) -> ElementTree.Element:
    """Return the <parent> or <child> of a joint; SimulationError when it names no link."""
    element = joint.find(end)
    link = None if element is None else element.get('link')
    if element is None or link not in links:
        raise SimulationError('joint {} has the {} link {}, which does not exist (links: {})'
                              .format(joint.get('name'), end, link, ', '.join(links)))
    return element


def _check_joint(joint: ElementTree.Element) -> None:
    kind, axis = joint.get('type'), joint.find('axis')
    if kind not in _JOINTS:
        raise SimulationError('joint {} is of type {}; supported are {}'.format(
            joint.get('name'), kind, ', '.join(_JOINTS)))
    name = 'axis of joint {}'.format(joint.get('name'))
    if axis is not None:
        read_direction(name, axis.get('xyz', '1 0 0'))


def _root(links: Dict[str, ElementTree.Element],
          parents: Dict[str, _Joint]) -> str:
    for name in links:
        ancestors, link = {name}, name
        while link in parents:
            link = parents[link].parent_link
            if link in ancestors:
                raise SimulationError('link {} is its own ancestor, through joint {}'.format(
                    link, parents[link].name))
            ancestors.add(link)
    roots = [name for name in links if name not in parents]
    if len(roots) != 1:
        raise SimulationError('got {} root links ({}), expected one'.format(
            len(roots), ', '.join(roots) or 'none'))
    return roots[0]


def _is_fixed(name: str, parents: Dict[str, _Joint]) -> bool:
    return name in parents and parents[name].element.get('type') == 'fixed'


def _frame(name: str, parents: Dict[str, _Joint], friction: Dict[str, float]) -> Frame:
    pose, carrier = IDENTITY, name
    while _is_fixed(carrier, parents) and carrier not in friction:
        joint = parents[carrier]
        pose = origin_of(joint.element) @ pose
        carrier = joint.parent_link
    return Frame(carrier, pose)


def frictions(robot: ElementTree.Element) -> Dict[str, float]:
    """Return the friction of the links that have one, by their names.

    It is mu1 of Gazebo's tag for the link, else PyBullet's lateral_friction.
    """
    found = {}
    of_tags = [(tag.get('reference'), tag.find('mu1')) for tag in robot.findall('gazebo')]
    for link in robot.findall('link'):
        name = link.get('name', '')
        of_tag = next((each for reference, each in of_tags
                       if reference == name and each is not None), None)
        of_link = link.find('contact/lateral_friction')
        if of_tag is not None:
            found[name] = read_coefficient('mu1 of link ' + name,
                                           of_tag.get('value') or of_tag.text)
        elif of_link is not None:
            found[name] = read_coefficient('lateral_friction of link ' + name,
                                           of_link.get('value'))
    return found


def _inertia(name: str, link: ElementTree.Element) -> Inertia:
    inertial = link.find('inertial')
    if inertial is None:
        return NO_INERTIA
    mass, inertia = inertial.find('mass'), inertial.find('inertia')
    if mass is None or inertia is None:
        raise SimulationError('link {}: <inertial> must have <mass> and <inertia>'.format(name))
    kilograms = read_number('mass of link ' + name, mass.get('value'))
    check_mass('mass of link ' + name, kilograms, ' (or no <inertial>)')
    values = ' '.join(inertia.get(key, '0') for key in INERTIA_KEYS)
    matrix = read_numbers('inertia of link ' + name, values, 9).reshape(3, 3)
    return Inertia(kilograms, np.zeros(3), matrix).moved(origin_of(inertial))


def _set_inertia(name: str, link: ElementTree.Element, inertia: Inertia) -> None:
    if inertia.mass == 0:
        raise SimulationError('link {} can move but has no mass'.format(name),
                              'add an <inertial> to it or to a link fixed to it')
    check_moments('link {}, with the links fixed to it,'.format(name), inertia.matrix)
    set_inertial(link, inertia.mass, Transform(np.eye(3), inertia.center), inertia.matrix)


def _move_shapes(source: ElementTree.Element, target: ElementTree.Element,
                 pose: Transform) -> None:
    for shape in source.findall('visual') + source.findall('collision'):
        set_origin(shape, pose @ origin_of(shape))
        target.append(shape)
