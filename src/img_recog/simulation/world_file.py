"""The file of a world, read once for all physics clients that build it."""
import math
import os
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, NamedTuple, Tuple

from img_recog.files import FindFile, find_in, find_user_path
from img_recog.simulation import meshes
from img_recog.simulation.geometry import Transform, from_rpy, to_rpy
from img_recog.simulation.settings import SimulationError

EMPTY = 'empty'
# Gazebo's models of the floor and the light, which every world here has
_BUILT_IN = ('model://ground_plane', 'model://sun')


class WorldFile(NamedTuple):
    """A world.

    name: of its model; text: URDF or SDF with meshes by absolute paths, nothing for the empty
    world; sdf: which of the two; warnings: what is in the file and not in `text`.
    """

    name: str
    text: str = ''
    sdf: bool = False
    warnings: Tuple[str, ...] = ()


def read(world: str, worlds: Dict[str, str],
         find_mesh: FindFile = lambda uri: None) -> WorldFile:
    """Return the world of the setting `world`.

    worlds: from the names that it may have besides a path, and `empty`, to paths of files.
    find_mesh: where mesh URIs are looked for that are no file beside the world's.
    Raises SimulationError when it cannot be read.
    """
    if world == EMPTY:
        return WorldFile(EMPTY)
    path = worlds.get(world) or os.path.expanduser(find_user_path(world))
    root = _parsed(world, path, worlds)
    beside = find_in(os.path.dirname(os.path.abspath(path)))
    missing = meshes.resolve(root, lambda uri: beside(uri) or find_mesh(uri))
    warnings = [meshes.described(missing)] if missing else []
    if root.tag == 'robot':
        _check_tree(world, root)
        return WorldFile(root.get('name', world), ElementTree.tostring(root, 'unicode'),
                         warnings=tuple(warnings))
    uris = [include.findtext('uri', '').strip() for include in root.iter('include')]
    strange = [uri for uri in uris if uri not in _BUILT_IN]
    if strange:
        warnings.append('world {}: PyBullet follows no <include>, left out: {}'.format(
            world, ', '.join(strange)))
    nested = [model.get('name', '') for model in root.findall('.//model/model')]
    if nested:
        warnings.append('world {}: PyBullet reads no <model> in a <model>, left out: {}'.format(
            world, ', '.join(nested)))
    for parent in [root, *root.findall('world')]:
        for model in parent.findall('model'):
            if model.findtext('static', '').strip() in ('1', 'true'):
                for link in model.findall('link'):
                    _make_static(link)
            parent.remove(model)
            parent.extend(_split(world, model))
    return WorldFile(os.path.splitext(os.path.basename(path))[0],
                     ElementTree.tostring(root, 'unicode'), True, tuple(warnings))


def _check_tree(world: str, robot: ElementTree.Element) -> None:
    children = {child.get('link') for child in robot.findall('joint/child')}
    roots = [link.get('name', '') for link in robot.findall('link')
             if link.get('name') not in children]
    if len(roots) > 1:      # PyBullet would crash
        raise SimulationError('world {}: has {} root links ({}), wants one; tie them together '
                              'with fixed joints'.format(world, len(roots), ', '.join(roots)))


def _make_static(link: ElementTree.Element) -> None:
    """Take away the mass: PyBullet knows neither <static>true nor joints to the world."""
    for inertial in link.findall('inertial'):
        link.remove(inertial)
    inertial = ElementTree.SubElement(link, 'inertial')
    ElementTree.SubElement(inertial, 'mass').text = '0'
    inertia = ElementTree.SubElement(inertial, 'inertia')
    for key in ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'):
        ElementTree.SubElement(inertia, key).text = '0'


def _split(world: str, model: ElementTree.Element) -> List[ElementTree.Element]:
    """Return a model for each root link of a model, with what hangs on it, where that link is.

    PyBullet puts a root link where the model is, whatever the pose of the link, and crashes
    where there are several.
    """
    links = {link.get('name'): link for link in model.findall('link')}
    if not all(links) or len(links) < len(model.findall('link')):
        raise SimulationError('world {}: each <link> of model {} wants a name of its own'.format(
            world, model.get('name', '')))
    joints = [(joint.findtext('parent', '').strip(), joint.findtext('child', '').strip(), joint)
              for joint in model.findall('joint')]
    children = {child for parent, child, _ in joints if parent in links}
    parts = []
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
        for above in names:         # grows meanwhile
            part.append(links[above])
            for parent, child, joint in joints:
                if parent == above and child in links and child not in names:
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
        raise SimulationError('world {}: <pose> of {} {}: got {!r}, wants 6 finite numbers'.format(
            world, element.tag, element.get('name', ''), text))
    return from_rpy(values[:3], values[3:])


def _parsed(world: str, path: str, worlds: Dict[str, str]) -> ElementTree.Element:
    allowed = 'allowed is {}, {} or the path of a URDF or SDF file'.format(
        ', '.join(sorted(worlds)), EMPTY)
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, ValueError, LookupError) as error:     # the last: no such encoding
        raise SimulationError('world: got {!r}, which cannot be read as a file ({}); {}'.format(
            world, error, allowed))
    except ElementTree.ParseError as error:
        raise SimulationError('world: got {!r}, which is no XML ({}); {}'.format(
            world, error, allowed))
    if root.tag not in ('robot', 'sdf'):
        raise SimulationError('world: got {!r}, whose root element is <{}>, not <robot> (URDF) or '
                              '<sdf>; {}'.format(world, root.tag, allowed))
    return root
