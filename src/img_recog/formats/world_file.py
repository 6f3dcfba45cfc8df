"""Reads the file of a world; any number of physics clients can load the result."""
import dataclasses
import os
import re
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, NamedTuple, Optional, Tuple, Union

from img_recog.errors import SimulationError
from img_recog.files import FindFile, find_in, find_user_path
from img_recog.formats import lumping, sdf_file, sdf_versions, urdf
from img_recog.formats.audit import Finding
from img_recog.formats.markup import MarkupError, check_expanded, parse_xml, read_bytes
from img_recog.formats.problems import Problems
from img_recog.model import SUN, Light, Model, Surroundings, Tree
from img_recog.rotations import Transform

ReadFile = Callable[[str], Union[str, bytes]]

EMPTY = 'empty'
GRAVITY = (0.0, 0.0, -9.8)      # m/s2, Gazebo's default


class WorldFile(NamedTuple):
    """A world.

    name: of its model or file; trees: what stands in it, besides that floor; gravity (3,): m/s2;
    warnings: a line for each thing that was left out; has_floor: whether there is Gazebo's
    ground_plane, at z 0; camera: the pose of Gazebo's user camera in the world, if the file
    gives it; left_out: what cannot be used; missing_looks: materials and textures that are not
    found; findings: what is not done as asked; lights: those of no link.
    """

    name: str
    trees: Tuple[Tree, ...] = ()
    gravity: Tuple[float, ...] = GRAVITY
    warnings: Tuple[str, ...] = ()
    has_floor: bool = True
    camera: Optional[Transform] = None
    left_out: Tuple[str, ...] = ()
    missing_looks: Tuple[str, ...] = ()
    findings: Tuple[Finding, ...] = ()
    lights: Tuple[Light, ...] = (SUN,)
    surroundings: Surroundings = Surroundings()


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
    path = path if os.path.isfile(path) else find(path) or path     # like worlds/hall.world
    root = _parsed(world, path, worlds, read_file)
    problems = Problems()
    sdf_versions.unify(root)
    problems.audit(root)
    try:
        if root.tag == 'robot':
            file = _read_urdf(world, root, path, find, problems)
        else:
            file = _read_sdf(root, path, find, problems)
    except SimulationError as error:
        raise SimulationError('world {}: {}'.format(world, error.problem), error.advice)
    name = 'world {}'.format(world)
    if not allow_partial:
        problems.refuse(name, 'add {} to load the rest'.format(option))
    return file._replace(warnings=(*problems.warnings(name), *file.warnings),
                         left_out=problems.names, missing_looks=problems.looks,
                         findings=problems.findings)


def _read_urdf(world: str, root: ElementTree.Element, path: str,
               find: FindFile, problems: Problems) -> WorldFile:
    in_folder = find_in(os.path.dirname(os.path.abspath(path)))
    model = urdf.read(root, lambda uri: in_folder(uri) or find(uri))
    tree = fixed_tree(model, root.get('name', world), problems)
    return WorldFile(tree.name, (tree,))


def fixed_tree(model: Model, name: str, problems: Problems) -> Tree:
    """Return a URDF whose root link never moves; problems: to which is added what is not found.

    Raises SimulationError when it has several root links.
    """
    problems.add_missing(model)
    if len(model.roots) > 1:      # PyBullet would crash
        raise SimulationError('got {} root links ({}), expected one'.format(
            len(model.roots), ', '.join(model.roots)), 'connect them with fixed joints')
    links = tuple(link._replace(solids=tuple(solid._replace(is_concave=True)
                                             for solid in link.solids)) for link in model.links)
    return Tree(name, lumping.divided(dataclasses.replace(model, links=links)), fixed=True)


def _read_sdf(root: ElementTree.Element, path: str, find: FindFile,
              problems: Problems) -> WorldFile:
    contents = sdf_file.read(root, path, find, problems)
    gravity = GRAVITY if contents.gravity is None else tuple(contents.gravity.tolist())
    name = os.path.splitext(os.path.basename(path))[0]
    warnings = tuple('world {}: model {}: {}'.format(name, tree.name, warning)
                     for tree in contents.trees for warning in tree.model.warnings)
    return WorldFile(name, contents.trees, gravity, warnings, contents.has_floor, contents.camera,
                     lights=contents.lights, surroundings=contents.surroundings)


def _parsed(world: str, path: str, worlds: Dict[str, str],
            read_file: ReadFile) -> ElementTree.Element:
    allowed = 'allowed is {}, {} or the path of a URDF or SDF file'.format(
        ', '.join(sorted(worlds)), EMPTY)
    try:
        root = parse_xml(read_file(path))
        check_expanded(root)
    except (OSError, ValueError) as error:
        if re.fullmatch(r'turtlebot3_\w+', world) and not any(
                each.endswith('.world') for each in worlds.values()):
            raise SimulationError(
                'world: got {!r}, and the package turtlebot3_gazebo with its worlds is not found'
                .format(world), 'build it in a workspace and source its setup.bash; ' + allowed)
        raise SimulationError('world: got {!r}, which cannot be read as a file ({})'.format(
            world, error), allowed)
    except MarkupError as error:
        raise SimulationError('world: got {!r}, which cannot be used ({})'.format(
            world, error.problem), error.advice or allowed)
    if root.tag not in ('robot', 'sdf'):
        raise SimulationError('world: got {!r}, whose root element is <{}>, not <robot> (URDF) or '
                              '<sdf>'.format(world, root.tag), allowed)
    return root
