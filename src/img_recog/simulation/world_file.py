"""The file of a world, read once for all physics clients that build it."""
import os
import xml.etree.ElementTree as ElementTree
from typing import Dict, NamedTuple, Tuple

from img_recog.simulation import meshes
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
         find_mesh: meshes.FindMesh = lambda uri: None) -> WorldFile:
    """Return the world of the setting `world`.

    worlds: from the names that it may have besides a path, and `empty`, to paths of files.
    find_mesh: where mesh URIs are looked for that are no file beside the world's.
    Raises SimulationError when it cannot be read.
    """
    if world == EMPTY:
        return WorldFile(EMPTY)
    path = worlds.get(world, os.path.expanduser(world))
    root = _parsed(world, path, worlds)
    beside = meshes.find_file(os.path.dirname(os.path.abspath(path)))
    missing = meshes.resolve(root, lambda uri: beside(uri) or find_mesh(uri))
    warnings = [meshes.described(missing)] if missing else []
    if root.tag == 'robot':
        return WorldFile(root.get('name', world), ElementTree.tostring(root, 'unicode'),
                         warnings=tuple(warnings))
    uris = [include.findtext('uri', '').strip() for include in root.iter('include')]
    strange = [uri for uri in uris if uri not in _BUILT_IN]
    if strange:
        warnings.append('world {}: PyBullet follows no <include>, left out: {}'.format(
            world, ', '.join(strange)))
    for model in root.iter('model'):
        if model.findtext('static', '').strip() in ('1', 'true'):
            _make_static(model)
    return WorldFile(os.path.splitext(os.path.basename(path))[0],
                     ElementTree.tostring(root, 'unicode'), True, tuple(warnings))


def _make_static(model: ElementTree.Element) -> None:
    """Take away the mass, since PyBullet takes no notice of <static>."""
    for link in model.iter('link'):
        for inertial in link.findall('inertial'):
            link.remove(inertial)
        inertial = ElementTree.SubElement(link, 'inertial')
        ElementTree.SubElement(inertial, 'mass').text = '0'
        inertia = ElementTree.SubElement(inertial, 'inertia')
        for key in ('ixx', 'ixy', 'ixz', 'iyy', 'iyz', 'izz'):
            ElementTree.SubElement(inertia, key).text = '0'


def _parsed(world: str, path: str, worlds: Dict[str, str]) -> ElementTree.Element:
    allowed = 'allowed is {}, {} or the path of a URDF or SDF file'.format(
        ', '.join(sorted(worlds)), EMPTY)
    try:
        root = ElementTree.parse(path).getroot()
    except (OSError, UnicodeDecodeError, ValueError) as error:
        raise SimulationError('world: got {!r}, which cannot be read as a file ({}); {}'.format(
            world, error, allowed))
    except ElementTree.ParseError as error:
        raise SimulationError('world: got {!r}, which is no XML ({}); {}'.format(
            world, error, allowed))
    if root.tag not in ('robot', 'sdf'):
        raise SimulationError('world: got {!r}, whose root element is <{}>, not <robot> (URDF) or '
                              '<sdf>; {}'.format(world, root.tag, allowed))
    return root
