"""The links and joints of a URDF: a tree with one root, in which each has a name."""
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, NamedTuple

from img_recog.simulation.descriptions.numbers import read_direction
from img_recog.simulation.descriptions.texts import name_of
from img_recog.simulation.descriptions.urdf_elements import roots
from img_recog.simulation.settings import SimulationError

_KINDS = ('continuous', 'fixed', 'prismatic', 'revolute')

Links = Dict[str, ElementTree.Element]


class Joint(NamedTuple):
    """A joint: its name, its element and the <parent> in it."""

    name: str
    element: ElementTree.Element
    parent: ElementTree.Element

    @property
    def parent_link(self) -> str:
        """The name of the link that it is attached to."""
        return self.parent.attrib['link']

    @property
    def is_fixed(self) -> bool:
        """Whether its child does not move in its parent."""
        return self.element.get('type') == 'fixed'


class UrdfTree(NamedTuple):
    """links: elements by name, none before that which it is joined to; parents: the joint above
    each link but the root, by the name of the link; root: its name."""

    links: Links
    parents: Dict[str, Joint]
    root: str


def read(robot: ElementTree.Element) -> UrdfTree:
    """Return the tree of a <robot>.

    Raises SimulationError when it is none, a name is used twice, or a joint that moves has no
    direction or a type that is not simulated.
    """
    _check_names(robot)
    links = {name_of(link): link for link in robot.findall('link')}
    parents = _joints_by_child(robot, links)
    children: Dict[str, List[str]] = {}
    for link, joint in parents.items():
        _check_joint(joint)
        children.setdefault(joint.parent_link, []).append(link)
    _check_ancestors(links, parents)
    found = roots(robot)
    if len(found) != 1:
        others = sorted({element.tag for element in robot})
        raise SimulationError(
            'got {} root links ({}), expected one'.format(
                len(found), ', '.join(found) or 'none'),
            'its elements are <{}>; xacro expands macros only with the prefix xacro:'.format(
                '>, <'.join(others)) if others and not links else '')
    names = [found[0]]
    for name in names:          # grows while it is iterated over
        names += children.get(name, [])
    return UrdfTree({name: links[name] for name in names}, parents, found[0])


def _check_names(robot: ElementTree.Element) -> None:
    for tag in ('link', 'joint'):
        names = [element.get('name') for element in robot.findall(tag)]
        if None in names or len(set(names)) < len(names):
            raise SimulationError('each <{}> must have a unique name (names: {})'.format(
                tag, ', '.join(map(str, names))))


def _joints_by_child(robot: ElementTree.Element, links: Links) -> Dict[str, Joint]:
    joints: Dict[str, Joint] = {}
    for joint in robot.findall('joint'):
        name = name_of(joint)
        parent, child = (_end(joint, end, links) for end in ('parent', 'child'))
        link = child.attrib['link']
        if link in joints:
            raise SimulationError('link {} is the child of two joints, {} and {}'.format(
                link, joints[link].name, name))
        joints[link] = Joint(name, joint, parent)
    return joints


def _end(joint: ElementTree.Element, end: str, links: Links) -> ElementTree.Element:
    """Return the <parent> or <child> of a joint; SimulationError when it names no link."""
    element = joint.find(end)
    link = None if element is None else element.get('link')
    if element is None or link not in links:
        raise SimulationError('joint {} has the {} link {}, which does not exist (links: {})'
                              .format(joint.get('name'), end, link, ', '.join(links)))
    return element


def _check_joint(joint: Joint) -> None:
    kind, axis = joint.element.get('type'), joint.element.find('axis')
    if kind not in _KINDS:
        raise SimulationError('joint {} is of type {}; supported are {}'.format(
            joint.name, kind, ', '.join(_KINDS)))
    # programs that export from CAD write the axis 0 0 0 where nothing moves
    if joint.is_fixed:
        return
    if axis is None:
        axis = ElementTree.SubElement(joint.element, 'axis')
    axis.set('xyz', axis.get('xyz', '1 0 0'))       # or PyBullet prints a warning
    read_direction('axis of joint ' + joint.name, axis.get('xyz'))


def _check_ancestors(links: Links, parents: Dict[str, Joint]) -> None:
    """Raise SimulationError when links are joined in a circle."""
    for name in links:
        ancestors, link = {name}, name
        while link in parents:
            link = parents[link].parent_link
            if link in ancestors:
                raise SimulationError('link {} is its own ancestor, through joint {}'.format(
                    link, parents[link].name))
            ancestors.add(link)
