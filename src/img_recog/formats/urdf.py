"""Reads a URDF: its links and joints as the file has them; lumping.py makes a robot of them.

What Gazebo's tags say of links is in them: friction, materials and contact sensors.
"""
import xml.etree.ElementTree as ElementTree
from typing import Iterable, List, Tuple, Union

from img_recog.errors import SimulationError
from img_recog.files import FindFile
from img_recog.formats import drive_controllers
from img_recog.formats.drive_controllers import FindControllers
from img_recog.formats.markup import MarkupError, check_expanded, parse_xml
from img_recog.formats.reader import is_true, name_of, read as read_text
from img_recog.formats.urdf_links import Links, origin_of, text_of_tags
from img_recog.model import FIXED, PRISMATIC, REVOLUTE, Joint, Limits, Model, Tag
from img_recog.report import NOTE, Report


def root_of(urdf: Union[str, ElementTree.Element]) -> ElementTree.Element:
    """Return the <robot> of a URDF's text, or of what was parsed of it.

    Raises SimulationError when it is not a URDF.
    """
    try:
        robot = parse_xml(urdf) if isinstance(urdf, str) else urdf
        check_expanded(robot)
    except MarkupError as error:
        raise SimulationError(error.problem, error.advice or 'check the file given as urdf')
    if robot.tag != 'robot':
        raise SimulationError('got the root element <{}>, expected <robot> (URDF)'.format(
            robot.tag))
    return robot


def read(robot: ElementTree.Element, find: FindFile, report: Report,
         controllers: FindControllers = drive_controllers.none) -> Model:
    """Return the links and joints of a <robot>.

    find: returns the path of a mesh's or texture's URI. A shape whose mesh is not found is left
    out; where a link has no visual (or collision) shape left because of that, it gets its
    collision (or visual) shapes. report: gets what is not found. controllers:
    returns those of ros_control that it can have.
    Raises SimulationError when a name is missing or used twice, a joint has no link at an end, or
    a number cannot be used.
    """
    for tag in ('link', 'joint'):
        names = [element.get('name') for element in robot.findall(tag)]
        if None in names or len(set(names)) < len(names):
            raise SimulationError('each <{}> must have a unique name (names: {})'.format(
                tag, ', '.join(map(str, names))))
    links = [name_of(link) for link in robot.findall('link')]
    if not links:
        others = sorted({element.tag for element in robot})
        raise SimulationError(
            'got 0 root links (none), expected one',
            'its elements are <{}>; xacro expands macros only with the prefix xacro:'.format(
                '>, <'.join(others)) if others else '')
    held = drive_controllers.held(robot, controllers)
    joints = tuple(_joint(joint, links, robot)._replace(held=held.get(name_of(joint), 0.0))
                   for joint in robot.findall('joint'))
    _name_lumped_links(robot, joints)
    reader = Links(robot, find, report)
    xacro = check_expanded(robot)
    if xacro:
        report.add(NOTE, 'it contains xacro ({}), which is not expanded'.format(xacro))
    return Model(
        robot.get('name') or 'robot', tuple(map(reader.link, robot.findall('link'))), joints,
        surfaces={tag.attrib['reference']: () for tag in robot.findall('gazebo[@reference]')
                  if tag.find("sensor[@type='contact']/plugin") is not None},
        tags=tuple(Tag(tag.get('reference', ''), tag) for tag in robot.findall('gazebo')),
        can_sleep=robot.find('gazebo/sensor') is None
        and is_true(text_of_tags(robot, '', 'allow_auto_disable') or '1'))


def used_tags(robot: ElementTree.Element, model: Model) -> Tuple[List[Tag], List[str]]:
    """Return the <gazebo> tags of a <robot> that Gazebo looks at, and the links that others name.

    model: lumped; those of links that it does not have are not looked at.
    """
    known = {'', *model.frames, *(joint.get('name') for joint in robot.findall('joint'))}
    return ([tag for tag in model.tags if tag.link in known],
            list(dict.fromkeys(tag.link for tag in model.tags if tag.link not in known)))


def _name_lumped_links(robot: ElementTree.Element, joints: Iterable[Joint]) -> None:
    """Let plugins outside of sensors name the links into which those that they name are lumped.

    As Gazebo's SDFormat does, which moves them there.
    """
    above = {joint.child: joint.parent for joint in joints if joint.kind == FIXED and not is_true(
        text_of_tags(robot, joint.name, 'disableFixedJointLumping', 'preserveFixedJoint'))}
    for plugin in robot.findall('gazebo/plugin'):
        for element in (*plugin.findall('bodyName'), *plugin.findall('frameName')):
            name, higher = (element.text or '').strip(), dict(above)
            while name in higher:
                name = higher.pop(name)         # a link can be its own ancestor
            element.text = name


def _joint(joint: ElementTree.Element, links: List[str], robot: ElementTree.Element) -> Joint:
    name, kind = name_of(joint), joint.get('type', '')
    parent, child = (_end(joint, end, links) for end in ('parent', 'child'))
    axis, limit, dynamics = (joint.find(tag) for tag in ('axis', 'limit', 'dynamics'))
    direction = None
    # programs that export from CAD write the axis 0 0 0 where nothing moves
    if kind != FIXED:
        direction = read_text('axis', '1 0 0' if axis is None else axis.get('xyz', '1 0 0'),
                              'axis of joint ' + name)

    def number(element: ElementTree.Element, key: str, default: str = '0') -> float:
        return read_text('limit', element.get(key, default), '{} of joint {}'.format(key, name))
    limits = None
    if limit is not None:       # as in Gazebo, those that are swapped are put in order
        lower, upper = sorted(number(limit, key) for key in ('lower', 'upper'))
        limits = Limits(lower, upper, number(limit, 'effort'), number(limit, 'velocity'))
    elif kind in (REVOLUTE, PRISMATIC):
        raise SimulationError(
            'joint {} of type {} has no <limit>, which Gazebo refuses too'.format(name, kind),
            'add <limit lower="..." upper="..." effort="..." velocity="..."/>' + (
                ', or make its type continuous' if kind == REVOLUTE else ''))
    damping, friction = (
        abs(read_text('number', '0' if dynamics is None else dynamics.get(key, '0'),
                      '{} of joint {}'.format(key, name)))
        for key in ('damping', 'friction'))
    stiffness, reference = (
        read_text('number', text_of_tags(robot, name, tag) or '0',
                  '<{}> of joint {}'.format(tag, name))
        for tag in ('springStiffness', 'springReference'))
    return Joint(name, kind, parent, child, origin_of(joint), direction, limits, damping, friction,
                 stiffness, reference)


def _end(joint: ElementTree.Element, end: str, links: List[str]) -> str:
    """Return the link that the <parent> or <child> of a joint names."""
    element = joint.find(end)
    link = None if element is None else element.get('link')
    if link not in links:
        raise SimulationError('joint {} has the {} link {}, which does not exist (links: {})'
                              .format(joint.get('name'), end, link, ', '.join(links)))
    return link
