"""Reads the file of a world; any number of physics clients can load the result."""
import os
import re
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple, Union

from img_recog.files import FindFile, find_in, find_user_path
from img_recog.markup import MarkupError, check_expanded, parse_xml, read_bytes
from img_recog.simulation.descriptions import materials, meshes, sdf_file, urdf_visuals
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform
from img_recog.simulation.descriptions.sdf_models import Tree
from img_recog.simulation.descriptions.urdf_elements import roots
from img_recog.simulation.settings import SimulationError

ReadFile = Callable[[str], Union[str, bytes]]

EMPTY = 'empty'
GRAVITY = (0.0, 0.0, -9.8)      # m/s2, Gazebo's default
# what helps when a name fits a pattern; the scripts of a material are in the folder of a model
_ADVICE = (
    ('model://|^material (?!Gazebo/)', 'set GAZEBO_MODEL_PATH to the folders of the models'),
    ('package://', 'build the packages and source their setup.bash'),
    (sdf_file.NOT_DOWNLOADED, 'download the models and include them by model://NAME'))


class WorldFile(NamedTuple):
    """A world.

    name: of its model or file; trees: what stands in it, besides the floor; gravity (3,): m/s2;
    has_physics: whether the file has a <physics>, which is not used; warnings: a line for each
    thing that was left out; has_floor: whether the floor is seen, which carries in every world;
    camera: the pose of Gazebo's user camera in the world, if the file gives it.
    """

    name: str
    trees: Tuple[Tree, ...] = ()
    gravity: Tuple[float, ...] = GRAVITY
    has_physics: bool = False
    warnings: Tuple[str, ...] = ()
    has_floor: bool = True
    camera: Optional[Transform] = None


def read(world: str, worlds: Dict[str, str], find: FindFile = lambda uri: None,
         allow_partial: bool = False, option: str = 'allow_partial_world:=true',
         read_file: ReadFile = read_bytes) -> WorldFile:
    """Return the world that the setting `world` names: a key of `worlds`, `empty` or a path.

    worlds: paths of world files by name. find: returns the path of a file or folder at a URI that
    is not in the folder of the world file. allow_partial: whether a world of which something
    cannot be had is loaded without that, with a warning. option: what the user types to set that.
    read_file: returns the content of the world file; it raises UserError when it cannot.
    Raises SimulationError when it cannot be read.
    """
    if world == EMPTY:
        return WorldFile(EMPTY)
    path = worlds.get(world) or os.path.expanduser(find_user_path(world))
    root = _parsed(world, path, worlds, read_file)
    try:
        if root.tag == 'robot':
            file, missing = _read_urdf(world, root, path, find)
        else:
            file, missing = _read_sdf(root, path, find)
    except SimulationError as error:
        raise SimulationError('world {}: {}'.format(world, error.problem), error.advice)
    missing, looks = materials.split_looks(missing)
    if looks:
        file = file._replace(warnings=(
            *file.warnings, 'world {}: {}'.format(world, warning_about(looks))))
    if missing and not allow_partial:
        raise SimulationError(
            'world {}: not found, or not supported: {}'.format(world, ', '.join(missing)),
            ', or '.join([*advice_on(missing), 'add {} to load the rest'.format(option)]))
    if missing:
        file = file._replace(warnings=(
            'world {}: loaded without: {}'.format(world, ', '.join(missing)), *file.warnings))
    return file


def warning_about(looks: Sequence[str]) -> str:
    """Return what is warned of materials and textures that are not found, by name."""
    return '; '.join(['not found, drawn in another color: ' + ', '.join(looks),
                      *advice_on(looks)])


def advice_on(missing: Sequence[str]) -> List[str]:
    """Return what can be done so that things are found, which are given by their names."""
    return [advice for pattern, advice in _ADVICE
            if any(re.search(pattern, name) for name in missing)]


def _read_urdf(world: str, root: ElementTree.Element, path: str,
               find: FindFile) -> Tuple[WorldFile, Sequence[str]]:
    in_folder = find_in(os.path.dirname(os.path.abspath(path)))
    tree, missing = fixed_tree(root, root.get('name', world),
                               lambda uri: in_folder(uri) or find(uri))
    return WorldFile(tree.name, (tree,)), missing


def fixed_tree(robot: ElementTree.Element, name: str,
               find: FindFile) -> Tuple[Tree, Sequence[str]]:
    """Return a URDF whose root link never moves, and names of what was not found.

    Raises SimulationError when it has several root links.
    """
    missing = ['mesh ' + uri for uri in meshes.resolve(robot, find)]
    missing += urdf_visuals.apply_materials(robot, find)
    for collision in robot.findall('link/collision'):
        if collision.find('geometry/mesh') is not None:
            collision.set('concave', 'yes')
    urdf_visuals.check_shapes(robot)
    found = roots(robot)
    if len(found) > 1:      # PyBullet would crash
        raise SimulationError('got {} root links ({}), expected one'.format(
            len(found), ', '.join(found)), 'connect them with fixed joints')
    return Tree(name, ElementTree.tostring(robot, 'unicode'), IDENTITY, True), missing


def _read_sdf(root: ElementTree.Element, path: str,
              find: FindFile) -> Tuple[WorldFile, Sequence[str]]:
    contents = sdf_file.read(root, path, find)
    gravity = GRAVITY if contents.gravity is None else tuple(contents.gravity.tolist())
    name = os.path.splitext(os.path.basename(path))[0]
    warnings = () if not contents.ignored else ('world {}: not simulated: {}'.format(
        name, ', '.join(contents.ignored)),)
    warnings += tuple('world {}: model {}: {}'.format(name, tree.name, warning)
                      for tree in contents.trees for warning in tree.warnings)
    return WorldFile(name, contents.trees, gravity, contents.has_physics, warnings,
                     contents.has_floor, contents.camera), contents.missing


def _parsed(world: str, path: str, worlds: Dict[str, str],
            read_file: ReadFile) -> ElementTree.Element:
    allowed = 'allowed is {}, {} or the path of a URDF or SDF file'.format(
        ', '.join(sorted(worlds)), EMPTY)
    try:
        root = parse_xml(read_file(path))
        check_expanded(root)
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
