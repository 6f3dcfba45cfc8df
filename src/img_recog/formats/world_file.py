"""Reads the file of a world; any number of physics clients can load the result."""
import dataclasses
import os
import re
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, Union

from img_recog.errors import SimulationError, suggestion
from img_recog.files import FindFile, find_in, find_user_path
from img_recog.formats import audit, lumping, sdf_file, sdf_versions, urdf
from img_recog.formats.markup import MarkupError, check_expanded, parse_xml, read_bytes
from img_recog.formats.sdf_file import WorldFile
from img_recog.model import Model, Tree
from img_recog.report import Report

ReadFile = Callable[[str], Union[str, bytes]]

EMPTY = 'empty'
_WORLDS_OF_TURTLEBOT3 = r'turtlebot3_(house|stage_\d|autorace\w*|empty\w*)'


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
    report = Report('world {}'.format(world))
    sdf_versions.unify(root)
    report.extend(audit.audit(root))
    try:
        if root.tag == 'robot':
            file = _read_urdf(world, root, path, find, report)
        else:
            file = _read_sdf(root, path, find, report)
    except SimulationError as error:
        raise SimulationError('world {}: {}'.format(world, error.problem), error.advice)
    if not allow_partial:
        report.refuse('add {} to load the rest'.format(option))
    return file._replace(findings=report.findings)


def _read_urdf(world: str, root: ElementTree.Element, path: str,
               find: FindFile, report: Report) -> WorldFile:
    in_folder = find_in(os.path.dirname(os.path.abspath(path)))
    model = urdf.read(root, lambda uri: in_folder(uri) or find(uri), report)
    tree = fixed_tree(model, root.get('name', world))
    return WorldFile(tree.name, (tree,))


def fixed_tree(model: Model, name: str) -> Tree:
    """Return a URDF whose root link never moves.

    Raises SimulationError when it has several root links.
    """
    if len(model.roots) > 1:      # PyBullet would crash
        raise SimulationError('got {} root links ({}), expected one'.format(
            len(model.roots), ', '.join(model.roots)), 'connect them with fixed joints')
    links = tuple(link._replace(solids=tuple(solid._replace(is_concave=True)
                                             for solid in link.solids)) for link in model.links)
    return Tree(name, lumping.divided(dataclasses.replace(model, links=links)), fixed=True)


def _read_sdf(root: ElementTree.Element, path: str, find: FindFile,
              report: Report) -> WorldFile:
    file = sdf_file.read(root, path, find, report)
    return file._replace(name=os.path.splitext(os.path.basename(path))[0])


def _parsed(world: str, path: str, worlds: Dict[str, str],
            read_file: ReadFile) -> ElementTree.Element:
    allowed = 'allowed is {}, {} or the path of a URDF or SDF file'.format(
        ', '.join(sorted(worlds)), EMPTY)
    try:
        root = parse_xml(read_file(path))
        check_expanded(root)
    except (OSError, ValueError) as error:
        if re.fullmatch(_WORLDS_OF_TURTLEBOT3, world) and not any(
                each.endswith('.world') for each in worlds.values()):
            raise SimulationError(
                'world: got {!r}, and the package turtlebot3_gazebo with its worlds is not found'
                .format(world), 'build it in a workspace and source its setup.bash; ' + allowed)
        raise SimulationError('world: got {!r}, which cannot be read as a file ({})'.format(
            world, error), suggestion(world, [*worlds, EMPTY]) or allowed)
    except MarkupError as error:
        raise SimulationError('world: got {!r}, which cannot be used ({})'.format(
            world, error.problem), error.advice or allowed)
    if root.tag not in ('robot', 'sdf'):
        raise SimulationError('world: got {!r}, whose root element is <{}>, not <robot> (URDF) or '
                              '<sdf>'.format(world, root.tag), allowed)
    return root
