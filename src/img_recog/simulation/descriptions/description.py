"""Prepares a robot description (URDF) for PyBullet.

PyBullet gives a link without <inertial> a mass of 1 kg, and every fixed joint costs time in each
step. Therefore fixed links are lumped into the link that they are fixed to, like Gazebo's
SDFormat does: shapes are moved, masses and inertias added up, and `frames` keeps where each link
went. PyBullet has one coefficient of friction per link: shapes with another one than the link
that they are lumped into go to a link without mass, which is fixed to that.
"""
import os
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from typing import Dict, List, NamedTuple, Sequence, Set, Tuple

import numpy as np

from img_recog.files import FindFile, find_in
from img_recog.markup import MarkupError, check_expanded, parse_xml
from img_recog.simulation.descriptions import inertias, urdf_tree, urdf_visuals
from img_recog.simulation.descriptions.friction import FLOOR_FRICTION, frictions, of_surface
from img_recog.simulation.descriptions.geometry import IDENTITY, NO_INERTIA, Inertia, Transform
from img_recog.simulation.descriptions.meshes import resolve
from img_recog.simulation.descriptions.texts import name_of
from img_recog.simulation.descriptions.urdf_elements import (add_massless, origin_of,
                                                             set_friction, set_inertial,
                                                             set_origin)
from img_recog.simulation.descriptions.urdf_tree import UrdfTree
from img_recog.simulation.settings import SimulationError


class Frame(NamedTuple):
    """Where a link of the description went: its constant `pose` in the lumped `link`."""

    link: str
    pose: Transform


@dataclass(frozen=True)
class Description:
    """A lumped robot.

    name: of the robot; urdf: XML text for PyBullet; root: name of the root link; frames: of all
    links of the original description, but for those that are left out; friction: lateral friction
    coefficients of the lumped links with shapes, at most that of the floor; surfaces: of each link
    with a contact sensor, the links in `urdf` that have its shapes and no others; missing_meshes:
    URIs of meshes that were not found; missing_materials: what is not known or not found of the
    materials in <gazebo> tags; warnings: what is simulated in another way than given, a line each;
    left_out: joints that are left out; changed_inertias: the lumped links with another inertia
    than that.
    """

    name: str
    urdf: str
    root: str
    frames: Dict[str, Frame]
    friction: Dict[str, float]
    surfaces: Dict[str, List[str]]
    missing_meshes: Sequence[str] = ()
    missing_materials: Sequence[str] = ()
    warnings: Sequence[str] = ()
    left_out: Sequence[str] = ()
    changed_inertias: Sequence[str] = ()


def parse(urdf: str, find_mesh: FindFile = find_in(os.sep)) -> Description:
    """Read and lump a robot description.

    find_mesh: returns the path of a mesh's URI.
    Raises SimulationError when it is not a URDF, its links are not a tree, or a mass or another
    number cannot be simulated.
    """
    robot = root_of(urdf)
    xacro = check_expanded(robot)
    tree = urdf_tree.read(robot)
    missing = resolve(robot, find_mesh)
    missing_materials = urdf_visuals.apply_materials(robot, find_mesh)
    urdf_visuals.check_shapes(robot)
    frames = {name: _frame(name, tree) for name in tree.links}
    sums = _inertias(tree, frames)
    left_out, warnings = _leave_out(robot, tree, frames, sums)
    if xacro:
        warnings.append('it contains xacro ({}), which is not expanded'.format(xacro))
    coefficients = frictions(robot)
    watched: Dict[str, List[str]] = {
        tag.attrib['reference']: [] for tag in robot.findall('gazebo[@reference]')
        if tag.find("sensor[@type='contact']/plugin") is not None}
    for tag in robot.findall('gazebo'):
        robot.remove(tag)
    friction = _lump(robot, tree, frames, coefficients, watched)
    for joint in tree.parents.values():
        if not joint.is_fixed:
            carrier = frames[joint.parent_link]
            joint.parent.set('link', carrier.link)
            set_origin(joint.element, carrier.pose @ origin_of(joint.element))
    changed: List[str] = []
    for name, total in sums.items():
        possible = inertias.possible('link {} and what is fixed to it'.format(name), total.mass,
                                     total.matrix)
        set_inertial(tree.links[name], total.mass, Transform(np.eye(3), total.center),
                     possible.matrix)
        if possible.warning:
            warnings.append(possible.warning)
            changed.append(name)
    return Description(robot.get('name') or 'robot', ElementTree.tostring(robot, 'unicode'),
                       tree.root, frames, friction, watched, tuple(missing),
                       tuple(missing_materials), tuple(warnings), tuple(left_out),
                       tuple(changed))


def root_of(urdf: str) -> ElementTree.Element:
    """Return the <robot> of a URDF's text; SimulationError when it is not a URDF."""
    try:
        robot = parse_xml(urdf)
        check_expanded(robot)
    except MarkupError as error:
        raise SimulationError(error.problem, error.advice or 'check the file given as urdf')
    if robot.tag != 'robot':
        raise SimulationError('got the root element <{}>, expected <robot> (URDF)'.format(
            robot.tag))
    return robot


def without_unused_tags(urdf: str, robot: Description) -> Tuple[str, List[str]]:
    """Return the text of a URDF without the <gazebo> tags of links that the robot does not have.

    Gazebo does not look at those. Also returns the names of the links.
    """
    root = root_of(urdf)
    known = {joint.get('name') for joint in root.findall('joint')} | set(robot.frames) | {None, ''}
    unused = [tag for tag in root.findall('gazebo') if tag.get('reference') not in known]
    for tag in unused:
        root.remove(tag)
    names = list(dict.fromkeys(tag.attrib['reference'] for tag in unused))
    return ElementTree.tostring(root, 'unicode') if unused else urdf, names


def _frame(name: str, tree: UrdfTree) -> Frame:
    pose, carrier = IDENTITY, name
    while carrier in tree.parents and tree.parents[carrier].is_fixed:
        joint = tree.parents[carrier]
        pose = origin_of(joint.element) @ pose
        carrier = joint.parent_link
    return Frame(carrier, pose)


def _inertias(tree: UrdfTree, frames: Dict[str, Frame]) -> Dict[str, Inertia]:
    """Return the inertia of each lumped link, by its name."""
    sums: Dict[str, Inertia] = {}
    for name, frame in frames.items():
        sums[frame.link] = sums.get(frame.link, NO_INERTIA) + inertias.read(
            name, tree.links[name]).moved(frame.pose)
    return sums


def _leave_out(robot: ElementTree.Element, tree: UrdfTree, frames: Dict[str, Frame],
               sums: Dict[str, Inertia]) -> Tuple[List[str], List[str]]:
    """Remove the lumped links without mass, and what is joined to them, as Gazebo's SDFormat does.

    Returns the names of the joints, and warnings. Raises SimulationError when that is the whole
    robot.
    """
    if sums[tree.root].mass == 0:
        raise SimulationError('link {} can move but has no mass'.format(tree.root),
                              'add an <inertial> to it or to a link fixed to it')
    gone: Set[str] = set()
    warnings = []
    for name in sums:     # from the root on
        above = frames[tree.parents[name].parent_link].link if name in tree.parents else ''
        if sums[name].mass and above not in gone:
            continue
        gone.add(name)
        if above not in gone:
            warnings.append(
                'link {} can move (joint {}) but has no mass: it is left out with all that is '
                'joined to it, like in Gazebo'.format(name, tree.parents[name].name))
    joints = []
    for name in [name for name, frame in frames.items() if frame.link in gone]:
        del frames[name]
        robot.remove(tree.links.pop(name))
        joints.append(tree.parents.pop(name))
        robot.remove(joints[-1].element)
    for name in gone:
        del sums[name]
    return [joint.name for joint in joints], warnings


def _lump(robot: ElementTree.Element, tree: UrdfTree, frames: Dict[str, Frame],
          coefficients: Dict[str, float], watched: Dict[str, List[str]]) -> Dict[str, float]:
    """Move all shapes to the lumped links, and remove the others; return the friction of those.

    coefficients: of friction, by the names of the links. watched: the links whose shapes are kept
    apart from others; the names of those with their shapes are added to each.
    """
    friction: Dict[str, float] = {}
    surfaces: Dict[Tuple[str, float, str], ElementTree.Element] = {}
    for name, (carrier, pose) in frames.items():
        link = tree.links[name]
        if carrier != name:
            robot.remove(link)
            robot.remove(tree.parents[name].element)
            _move(link.findall('visual'), tree.links[carrier], pose)
        for shape in link.findall('collision'):
            value = min(coefficients[name] if name in coefficients else of_surface(shape, name),
                        FLOOR_FRICTION)
            key = carrier, value, name if name in watched else ''
            if key not in surfaces:
                surface = tree.links[carrier] if carrier not in friction else _add_surface(
                    robot, carrier, '{}/{:g}'.format(name, value)
                    if name in friction or name == carrier else name)
                set_friction(surface, value)
                friction[name_of(surface)] = value
                surfaces[key] = surface
                if name in watched:
                    watched[name].append(name_of(surface))
            if surfaces[key] is not link:
                link.remove(shape)
                _move([shape], surfaces[key], pose)
    return friction


def _add_surface(robot: ElementTree.Element, carrier: str, name: str) -> ElementTree.Element:
    """Add a link without mass, fixed to another one in the same place."""
    link = ElementTree.SubElement(robot, 'link', name=name)
    add_massless(link)
    joint = ElementTree.SubElement(robot, 'joint', name=name + '/joint', type='fixed')
    ElementTree.SubElement(joint, 'parent', link=carrier)
    ElementTree.SubElement(joint, 'child', link=name)
    return link


def _move(shapes: List[ElementTree.Element], target: ElementTree.Element,
          pose: Transform) -> None:
    for shape in shapes:
        set_origin(shape, pose @ origin_of(shape))
        target.append(shape)
