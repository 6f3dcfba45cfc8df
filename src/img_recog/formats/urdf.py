"""Reads a URDF: its links and joints as the file has them; lumping.py makes a robot of them.

What Gazebo's tags say of links is in them: friction, materials and contact sensors.
"""
import os
import xml.etree.ElementTree as ElementTree
from typing import Any, Dict, Iterable, List, Optional, Tuple, Union

import numpy as np

from img_recog.errors import SimulationError
from img_recog.files import FindFile
from img_recog.formats import drive_controllers, lumping, materials, sdf_links
from img_recog.formats.drive_controllers import FindControllers
from img_recog.formats.markup import MarkupError, check_expanded, parse_xml
from img_recog.formats.meshes.mesh_file import READABLE
from img_recog.formats.reader import is_true, name_of, read as read_text, text_of
from img_recog.formats.sdf_frames import pose_of
from img_recog.model import (ALL_BITS, BOX, CAPSULE, CYLINDER, FIXED, MESH, NO_INERTIA, PRISMATIC,
                             REVOLUTE, SPHERE, Friction, Inertia, Joint, Limits, Link, Look,
                             Material, Model, Shape, Solid, Tag)
from img_recog.report import LEFT_OUT, NOTE, NOT_FOUND, Report
from img_recog.rotations import IDENTITY, Transform, transform

_SIZES = {BOX: ('size',), CYLINDER: ('radius', 'length'), SPHERE: ('radius',),
          CAPSULE: ('radius', 'length')}
_DRAWN = (BOX, CYLINDER, SPHERE, MESH)
_NOT_DRAWN = 'got the geometry {}, expected box, cylinder, sphere or mesh'


def origin_of(element: ElementTree.Element) -> Transform:
    """Return the <origin> of an element: its pose in the frame of what it belongs to."""
    origin = element.find('origin')
    if origin is None:
        return IDENTITY
    name = '<origin> in <{} {}>'.format(element.tag, name_of(element))
    return transform(read_text('3lengths', origin.get('xyz', '0 0 0'), name),
                     read_text('3numbers', origin.get('rpy', '0 0 0'), name))


def text_of_tags(robot: ElementTree.Element, name: str, *paths: str) -> str:
    """Return the last text at one of some paths in the <gazebo> tags of a link or a joint, '' for
    none; name: '' for that of the robot itself."""
    return ([''] + [text_of(tag, path) for tag in robot.findall('gazebo')
                    if tag.get('reference', '') == name
                    for path in paths if tag.find(path) is not None])[-1]


class Links:
    """Reads the links of a <robot>, and what its tags say of them."""

    def __init__(self, robot: ElementTree.Element, find: FindFile, report: Report):
        """report: gets what is not found."""
        self._robot, self._find, self._report = robot, find, report
        self._tags = [tag for tag in robot.findall('gazebo') if tag.get('reference')]
        self._named = {material.get('name'): material for material in robot.findall('material')}
        self._textures: Dict[str, str] = {}
        for texture in robot.iterfind('.//material/texture'):
            uri = texture.get('filename', '')
            path = find(uri)
            if path is None:
                report.add(NOT_FOUND, 'texture ' + uri)
            self._textures[uri] = '' if path is None else os.path.abspath(path)
        self._materials: Dict[str, Material] = {}
        links = {name_of(link) for link in robot.findall('link')}
        for tag in self._tags:
            if tag.get('reference') in links:
                self._read_materials(tag)

    def link(self, link: ElementTree.Element) -> Link:
        """Return a link."""
        name, friction = name_of(link), self._friction(link)
        lost: Dict[str, List[ElementTree.Element]] = {'visual': [], 'collision': []}
        kept: Dict[str, List[Tuple[ElementTree.Element, Shape]]] = {
            'visual': [], 'collision': []}
        for tag in kept:
            for element in link.findall(tag):
                shape = self._shape(name, element)
                if shape is None:
                    lost[tag].append(element)
                else:
                    kept[tag].append((element, shape))
        looks = [self._look(name, element, element, shape) for element, shape in kept['visual']]
        if lost['visual'] and not looks:
            looks = [self._look(name, element, lost['visual'][0], shape)
                     for element, shape in kept['collision']]
        solids = [self._solid(name, element, shape, friction)
                  for element, shape in kept['collision']]
        if lost['collision'] and not solids:
            solids = [Solid(look.shape, look.pose, friction) for look in looks]
        lamps = [sdf_links.light(light, pose_of(light)) for tag in self._tags_of(name)
                 for light in tag.findall('light')]
        return Link(name, _inertia(link), tuple(solids), tuple(looks), _contact(link),
                    lights=tuple(lamps), **self._motion(name))

    def _motion(self, name: str) -> Dict[str, Any]:
        """Return what Gazebo's tags say of how a link moves, as fields of a Link."""
        factor = read_text('share', text_of_tags(self._robot, name, 'dampingFactor') or '0',
                           '<dampingFactor> of link ' + name)
        collides = text_of_tags(self._robot, name, 'selfCollide', 'self_collide') or text_of_tags(
            self._robot, '', 'self_collide')
        # each tag says it in Gazebo, also one without <turnGravityOff>
        tags = self._tags_of(name)
        return {'has_gravity': not is_true(tags[-1].findtext('turnGravityOff')) if tags else None,
                'decay': (factor, factor), 'space': name if is_true(collides) else ''}

    def _shape(self, link: str, element: ElementTree.Element) -> Optional[Shape]:
        """Return the shape of a <visual> or <collision>; None if its mesh is not found."""
        geometry = element.find('geometry/*')
        if geometry is None:
            raise SimulationError('<{} {}> has no geometry'.format(element.tag, name_of(element)))
        kind, path = geometry.tag, ''
        try:
            size = _size(geometry)
            if kind not in _DRAWN and (kind, element.tag) != (CAPSULE, 'collision'):
                raise SimulationError(_NOT_DRAWN.format(kind))
        except SimulationError as error:
            raise SimulationError('link {}, <{}>: {}'.format(link, element.tag, error.problem),
                                  error.advice)
        if kind == MESH:
            uri = geometry.get('filename') or text_of(geometry, 'uri')
            found = self._find(uri)
            if found is None or not found.lower().endswith(READABLE):
                self._report.add(LEFT_OUT, 'mesh ' + uri, advice='' if found is None else (
                    'meshes can be {} files'.format(', '.join(READABLE))))
                return None
            path = os.path.abspath(found)
        return Shape(kind, size, path)

    def _solid(self, link: str, element: ElementTree.Element, shape: Shape,
               friction: Optional[Friction]) -> Solid:
        if friction is None:
            # Gazebo reads it only in an SDF: who writes it here means it for all directions
            friction = sdf_links.friction_of(element, link)
            if friction is not None and element.find('surface/friction/ode/mu2') is None:
                friction = Friction(friction.mu)
        bitmasks = [sdf_links.bitmask(collision) for tag in self._tags_of(link)
                    for collision in tag.findall('collision')]
        contact = sdf_links.contact_of(element, link, self._text_of_tags(link))
        return Solid(shape, friction=friction, bitmask=min([ALL_BITS, *bitmasks]),
                     contact=contact).moved(origin_of(element))

    def _tags_of(self, link: str) -> List[ElementTree.Element]:
        return [tag for tag in self._tags if tag.get('reference') == link]

    def _text_of_tags(self, link: str) -> sdf_links.TextOf:
        """Return what returns the text of an element in Gazebo's tags for a link."""
        tags = self._tags_of(link)

        def text(element: str) -> Optional[str]:
            found = [each for tag in tags for each in tag.findall(element)]
            return (found[0].get('value') or found[0].text) if found else None

        return text

    def _friction(self, link: ElementTree.Element) -> Optional[Friction]:
        """Return that of all shapes of a link: <mu1>, <mu2> and <fdir1> of Gazebo's tags for it,
        or that of a collision there, else PyBullet's <lateral_friction>; None without.
        """
        name = name_of(link)
        found = [sdf_links.friction_of_texts(self._text_of_tags(name), name, 'mu1'),
                 *(sdf_links.friction_of(collision, name)
                   for tag in self._tags_of(name) for collision in tag.findall('collision'))]
        of_link = link.find('contact/lateral_friction')
        if of_link is not None:
            found.append(Friction(read_text('coefficient', of_link.get('value'),
                                            'lateral_friction of link ' + name)))
        return next((each for each in found if each is not None), None)

    def _look(self, link: str, element: ElementTree.Element, owner: ElementTree.Element,
              shape: Shape) -> Look:
        """Return what is seen of a shape; owner: the <visual> that has its material."""
        if shape.kind not in _DRAWN:
            raise SimulationError('link {}, <visual>: {}'.format(
                link, _NOT_DRAWN.format(shape.kind)))
        given = owner.find('material')
        material = None if given is None else self._material(given)
        if link in self._materials:
            return Look(shape, origin_of(element), self._materials[link])
        # In a URDF, a <material> is that of a mesh whose file has none, like in RViz; Gazebo 11
        # ignores it. That of a <gazebo> tag replaces that of the file.
        return Look(shape, origin_of(element), material, shape.kind == MESH and given is not None)

    def _material(self, element: ElementTree.Element) -> Optional[Material]:
        """Return what a <material> says, or the one of the same name beside the links."""
        color, path = self._color_and_texture(element)
        if color is None and not path:
            element = self._named.get(element.get('name'), element)
            color, path = self._color_and_texture(element)
        red, green, blue, opacity = read_text(
            '4numbers', '1 1 1 1' if color is None else color.get('rgba'),
            'rgba of material ' + name_of(element)).tolist()
        return None if color is None and not path else Material((red, green, blue, opacity), path)

    def _color_and_texture(self, element: ElementTree.Element
                           ) -> Tuple[Optional[ElementTree.Element], str]:
        texture = element.find('texture')
        return element.find('color'), '' if texture is None else self._textures[
            texture.get('filename', '')]

    def _read_materials(self, tag: ElementTree.Element) -> None:
        """Read those of a <gazebo> tag, for all visuals of its link; the last one counts."""
        found = [(materials.of_sdf(shape, self._find, self._report), materials.opacity(shape))
                 for shape in tag.findall('visual') if shape.find('material') is not None]
        found.append((materials.of_script(text_of(tag, 'material'), (), self._find,
                                          self._report), 1.0))
        for material, opacity in found:
            if material is not None:
                self._materials[tag.attrib['reference']] = material.faded(opacity)


def _size(element: ElementTree.Element) -> Tuple[float, ...]:
    """Return the size of a shape, or the scale of a mesh."""
    if element.tag == MESH:
        return tuple(read_text('3lengths', element.get('scale', '1 1 1'),
                               'scale of mesh').tolist())
    values = tuple(
        value for name in _SIZES.get(element.tag, ()) for value in np.ravel(read_text(
            '3lengths' if name == 'size' else 'length', element.get(name),
            '{} of {}'.format(name, element.tag))).tolist())
    if any(value < 0 for value in values):
        raise SimulationError('size of {}: got {}, expected no negative number'.format(
            element.tag, ' '.join('{:g}'.format(value) for value in values)))
    return values


def _contact(link: ElementTree.Element) -> Dict[str, float]:
    return {each.tag: read_text('number', each.get('value'),
                                '{} of link {}'.format(each.tag, name_of(link)))
            for each in link.findall('contact/*') if each.get('value') is not None}


def _inertia(link: ElementTree.Element) -> Optional[Inertia]:
    """Return the inertia of a link in its frame; None without, NO_INERTIA for a mass of 0."""
    inertial = link.find('inertial')
    if inertial is None:
        return None
    name, mass, inertia = name_of(link), inertial.find('mass'), inertial.find('inertia')
    if mass is None or inertia is None:
        raise SimulationError('link {}: <inertial> must have <mass> and <inertia>'.format(name))
    kilograms = read_text('mass', mass.get('value'), 'mass of link ' + name)
    values = ' '.join(inertia.get(key, '0') for key in lumping.INERTIA_KEYS)
    matrix = read_text('9numbers', values, 'inertia of link ' + name).reshape(3, 3)
    if kilograms == 0:
        return NO_INERTIA
    lumping.check_mass('mass of link ' + name, kilograms, ' (or no <inertial>)')
    return Inertia(kilograms, origin_of(inertial), matrix)


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
