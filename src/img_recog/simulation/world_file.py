"""Reads the file of a world; any number of physics clients can load the result."""
import math
import os
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, NamedTuple, Tuple

from img_recog.files import FindFile, find_in, find_user_path
from img_recog.markup import MarkupError, parse_xml, read_bytes
from img_recog.simulation import meshes
from img_recog.simulation.geometry import Transform, from_rpy, to_rpy
from img_recog.simulation.settings import SimulationError

EMPTY = 'empty'
# Gazebo's models of the floor and the light: the simulator has both in every world
_BUILT_IN = ('model://ground_plane', 'model://sun')


class WorldFile(NamedTuple):
    """A world.

    name: of its model; text: URDF or SDF in which meshes have absolute paths, '' for the empty
    world; sdf: whether `text` is SDF; warnings: one line for each thing that was left out.
    """

    name: str
    text: str = ''
    sdf: bool = False
    warnings: Tuple[str, ...] = ()


def read(world: str, worlds: Dict[str, str],
         find_mesh: FindFile = lambda uri: None) -> WorldFile:
    """Return the world that the setting `world` names: a key of `worlds`, `empty` or a path.

    worlds: paths of world files by name. find_mesh: finds the meshes that are not in the folder
    of the world file.
    Raises SimulationError when it cannot be read.
    """
    if world == EMPTY:
        return WorldFile(EMPTY)
    path = worlds.get(world) or os.path.expanduser(find_user_path(world))
    root = _parsed(world, path, worlds)
    in_folder = find_in(os.path.dirname(os.path.abspath(path)))
    missing = meshes.resolve(root, lambda uri: in_folder(uri) or find_mesh(uri))
    warnings = ['world {}: {}'.format(world, meshes.warning_about(missing))] if missing else []
    if root.tag == 'robot':
        _check_tree(world, root)
        return WorldFile(root.get('name', world), ElementTree.tostring(root, 'unicode'),
                         warnings=tuple(warnings))
    warnings += _left_out(world, root)
    for parent in [root, *root.findall('world')]:
        for model in parent.findall('model'):
            if model.findtext('static', '').strip() in ('1', 'true'):
                for link in model.findall('link'):
                    _make_static(link)
            parent.remove(model)
            parent.extend(_split(world, model))
    return WorldFile(os.path.splitext(os.path.basename(path))[0],
                     ElementTree.tostring(root, 'unicode'), True, tuple(warnings))


def _left_out(world: str, root: ElementTree.Element) -> List[str]:
    """Return a warning for each kind of element of an SDF that PyBullet does not read."""
    warnings = []
    uris = [include.findtext('uri', '').strip() for include in root.iter('include')]
    included = [uri for uri in uris if uri not in _BUILT_IN]
    if included:
        warnings.append('world {}: PyBullet does not follow <include>; left out: {}'.format(
            world, ', '.join(included)))
    nested = [model.get('name', '') for model in root.findall('.//model/model')]
    if nested:
        warnings.append('world {}: PyBullet does not read a <model> in a <model>; left out: {}'
                        .format(world, ', '.join(nested)))
    return warnings


def _check_tree(world: str, robot: ElementTree.Element) -> None:
    children = {child.get('link') for child in robot.findall('joint/child')}
    roots = [link.get('name', '') for link in robot.findall('link')
             if link.get('name') not in children]
    if len(roots) > 1:      # PyBullet would crash
        raise SimulationError('world {}: got {} root links ({}), expected one'.format(
            world, len(roots), ', '.join(roots)), 'connect them with fixed joints')


def _make_static(link: ElementTree.Element) -> None:
    """Set the mass to 0: PyBullet reads neither <static> nor joints to the world."""
    for inertial in link.findall('inertial'):
        link.remove(inertial)
    inertial = ElementTree.SubElement(link, 'inertial')
    ElementTree.SubElement(inertial, 'mass').text = '0'
    inertia = ElementTree.SubElement(inertial, 'inertia')
    for key in ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'):
        ElementTree.SubElement(inertia, key).text = '0'


def _split(world: str, model: ElementTree.Element) -> List[ElementTree.Element]:
    """Split a model into one model per root link, with the links below it, at that link's pose.

    PyBullet ignores the pose of a root link in its model, and crashes when there are several.
    """
    links = {link.get('name'): link for link in model.findall('link')}
    if not all(links) or len(links) < len(model.findall('link')):
        raise SimulationError('world {}: each <link> of model {} must have a unique name'.format(
            world, model.get('name', '')))
    joints = [(joint.findtext('parent', '').strip(), joint.findtext('child', '').strip(), joint)
              for joint in model.findall('joint')]
    children = {child for parent, child, _ in joints if parent in links}
    parts: List[ElementTree.Element] = []
    for root in (name for name in links if name not in children):
        name = model.get('name', '')
        part = ElementTree.Element(
            'model', name='{}::{}'.format(name, root) if parts else name)
        pose = _pose(world, model) @ _pose(world, links[root])
        ElementTree.SubElement(part, 'pose').text = ' '.join(
            repr(float(value)) for value in (*pose.translation, *to_rpy(pose.rotation)))
        if any(joint.get('type') == 'fixed' for parent, child, joint in joints
               if (parent, child) == ('world', root)):
            _make_static(links[root])
        names = [root]
        for link in names:          # grows while it is iterated over
            part.append(links[link])
            for parent, child, joint in joints:
                if parent == link and child in links and child not in names:
                    part.append(joint)
                    names.append(child)
        parts.append(part)
    return parts


def _pose(world: str, element: ElementTree.Element) -> Transform:
    text = element.findtext('pose', '').strip() or '0 0 0 0 0 0'
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != 6 or not all(math.isfinite(value) for value in values):
        raise SimulationError('world {}: <pose> of {} {}: got {!r}, expected 6 finite numbers'
                              .format(world, element.tag, element.get('name', ''), text))
    return from_rpy(values[:3], values[3:])


def _parsed(world: str, path: str, worlds: Dict[str, str]) -> ElementTree.Element:
    allowed = 'allowed is {}, {} or the path of a URDF or SDF file'.format(
        ', '.join(sorted(worlds)), EMPTY)
    try:
        root = parse_xml(read_bytes(path))
    except (OSError, ValueError) as error:
        raise SimulationError('world: got {!r}, which cannot be read as a file ({})'.format(
            world, error), allowed)
    except MarkupError as error:
        raise SimulationError('world: got {!r}, which cannot be used ({})'.format(
            world, error.problem), error.advice or allowed)
    if root.tag not in ('robot', 'sdf'):
        raise SimulationError('world: got {!r}, whose root element is <{}>, not <robot> (URDF) or '
                              '<sdf>'.format(world, root.tag), allowed)
    return root
