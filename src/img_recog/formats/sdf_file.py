"""Reads an SDF file with all that it includes."""
import copy
import os
import re
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, List, NamedTuple, Optional, Sequence, Set, Tuple
from urllib.parse import unquote

import numpy as np

from img_recog.errors import SimulationError
from img_recog.files import FindFile, plain
from img_recog.formats import (audit, generated_meshes, materials, sdf_frames, sdf_links,
                               sdf_models, sdf_populations, sdf_states, sdf_versions)
from img_recog.formats.markup import MarkupError, parse_xml, read_bytes
from img_recog.formats.reader import name_of, text_of, value, values
from img_recog.formats.sdf_frames import Scope
from img_recog.formats.sdf_joints import INCLUDED
from img_recog.formats.sdf_states import Starts
from img_recog.formats.sdf_versions import Version, version_of
from img_recog.model import MESH, SUN, Light, Link, Look, Model, Shape, Surroundings, Tree
from img_recog.report import NOT_DOWNLOADED, NOT_USED, Finding, Report
from img_recog.rotations import IDENTITY, Transform

_ABOVE_M = 0.005        # so that the floor is not seen in it
_ASPHALT = materials.gazebo_material('Gazebo/Road')
GRAVITY: Tuple[float, ...] = (0.0, 0.0, -9.8)       # m/s2, Gazebo's default
_MODEL_URI = 'model://'
_GROUND_PLANE = 'ground_plane'      # its name, and in place of the path of its file
_SUN = 'sun'
# Gazebo's models of the floor and the light, also those of the new Gazebo, with their version: the
# simulator has both
_BUILT_IN = re.compile(
    '(?:model://|https?://[^/]+/.*models/)(ground[ _]plane|sun)(?:/[0-9]+|/tip)?/?', re.IGNORECASE)
_GROUND_PLANE_XML = '''
<model name="ground_plane"><static>1</static><link name="link">
  <collision name="collision">
    <geometry><plane><size>100 100</size></plane></geometry>
    <surface><friction><ode><mu>100</mu><mu2>50</mu2></ode></friction></surface>
  </collision>
  <visual name="visual">
    <geometry><plane><size>100 100</size></plane></geometry>
    <material><script><name>Gazebo/Grey</name></script></material>
  </visual>
</link></model>'''
_MAX_NESTED, _MAX_INCLUDED = 100, 5000     # models in one another; included ones in total
_Found = Tuple[ElementTree.Element, Version, str]
_URLS = ('http://', 'https://', 'ftp://')


def find_relative(folder: str, find: FindFile) -> Callable[[str], Optional[str]]:
    """Return a function that finds files and folders: a relative path in `folder` first."""
    def found(uri: str) -> Optional[str]:
        path = uri[len('file://'):] if uri.startswith('file://') else uri
        joined = os.path.join(folder, path)
        return joined if path and '://' not in path and os.path.exists(joined) else find(uri)
    return found


def find_above(folder: str, path: str) -> Optional[str]:
    """Return where a model's path is: in a folder above, or in `models` in one."""
    while True:
        for candidate in (os.path.join(folder, path), os.path.join(folder, 'models', path)):
            if os.path.exists(candidate):
                return candidate
        parent = os.path.dirname(folder)
        if parent == folder:
            return None
        folder = parent


def model_file(path: str) -> Optional[str]:
    """Return the SDF file of a model: of a folder, that of the newest version in model.config."""
    if os.path.isfile(path):
        return os.path.abspath(path)
    names = ['model.sdf']
    config = os.path.join(path, 'model.config')
    if os.path.isfile(config):
        found = [(sdf_versions.version_of(sdf), (sdf.text or '').strip())
                 for sdf in parsed(config, 'model').findall('sdf')]
        names = [name for _, name in sorted(found, reverse=True) if name] + names
    paths = (os.path.join(path, name) for name in names)
    return next((os.path.abspath(each) for each in paths if os.path.isfile(each)), None)


def parsed(path: str, tag: str = 'sdf') -> ElementTree.Element:
    """Return the root element of a file; raise SimulationError if its tag is not `tag`."""
    try:
        root = parse_xml(read_bytes(path, opener=plain))
    except (OSError, ValueError) as error:
        raise SimulationError('cannot read {} ({})'.format(path, error))
    except MarkupError as error:
        raise SimulationError('cannot use {} ({})'.format(path, error.problem), error.advice)
    if root.tag != tag:
        raise SimulationError('the root element of {} is <{}>, not <{}>'.format(
            path, root.tag, tag))
    sdf_versions.unify(root)
    return root


class WorldFile(NamedTuple):
    """A world.

    name: of its model or file; trees: what stands in it, besides that floor; gravity (3,): m/s2;
    has_floor: whether there is Gazebo's
    ground_plane, at z 0; camera: the pose of Gazebo's user camera in the world, if the file
    gives it; findings: what is not done as the file asks; lights: those of no link.
    """

    name: str
    trees: Tuple[Tree, ...] = ()
    gravity: Tuple[float, ...] = GRAVITY
    has_floor: bool = True
    camera: Optional[Transform] = None
    findings: Tuple[Finding, ...] = ()
    lights: Tuple[Light, ...] = (SUN,)
    surroundings: Surroundings = Surroundings()


def read(root: ElementTree.Element, path: str, find: FindFile, report: Report) -> WorldFile:
    """Read an <sdf> element.

    The result has no name yet. path: of its file; find: returns the path of the file or folder at
    a URI. Models are also searched for in the folders above the file. report: to which is added
    what cannot be used.
    """
    world = root.find('world')
    reader = _Reader(find, report, has_floor=world is None)
    reader.read(root if world is None else world, version_of(root), path, (os.path.abspath(path),))
    gravity, camera, surroundings = GRAVITY, None, Surroundings()
    if world is not None:
        with report.left_out():
            given, in_physics = value(world, 'gravity'), value(world, 'physics/gravity')
            if given is None and in_physics is not None and version_of(root) >= (1, 6):
                report.add(NOT_USED, '<gravity> in <physics>, since SDF 1.6',
                                     'the world')        # as in Gazebo
            elif given is None:
                given = in_physics
            if given is not None:
                gravity = tuple(given.tolist())
        with report.left_out():
            element = world.find('gui/camera')
            if element is not None and element.find('pose') is not None:
                camera = sdf_frames.pose_of(element)
        with report.left_out():
            scene = world.find('scene')
            surroundings = surroundings if scene is None else sdf_links.surroundings(scene)
    # a model alone stands in Gazebo's empty world
    return WorldFile('', tuple(reader.trees), gravity, has_floor=reader.has_floor, camera=camera,
                     lights=(SUN,) if world is None else tuple(reader.lights.values()),
                     surroundings=surroundings)


class _Reader:
    """Collects the trees of a world and of the files that it includes."""

    def __init__(self, find: FindFile, report: Report, has_floor: bool):
        self._find, self._report = find, report
        self.trees: List[Tree] = []
        self.lights: Dict[str, Light] = {}      # by name
        self._names: Set[str] = set()
        self._audited: Set[str] = set()         # included files: thousands may be the same one
        self.has_floor = has_floor
        self._included_count = self._depth = 0

    def read(self, parent: ElementTree.Element, version: Version, path: str,
             stack: Sequence[str]) -> None:
        """Add the models in a <world> or an <sdf>."""
        # with their versions and files, in their order; relative to what else is in the world
        found: List[_Found] = []
        for element in list(parent):
            with self._report.left_out():
                if element.tag == 'include':
                    found += self._included(element, path, stack)
                elif element.tag == 'light':
                    self._add_light(element)
                elif element.tag in ('model', 'population'):
                    for model in (sdf_populations.models(element) if element.tag == 'population'
                                  else [copy.deepcopy(element)]):
                        if not any(each.tag in ('link', 'include') for each in model.iter()):
                            self._report.add(
                                NOT_USED, 'model {}, which has no link,'.format(name_of(model)),
                                path)
                        self._expand(model, path, stack)
                        found.append((model, version, path))
                elif element.tag == 'road':
                    self.trees.append(_road(element, self._finder(path), self._report))
                elif element.tag == 'actor':
                    raise SimulationError('actor {}'.format(name_of(element)).strip())
        frames = ElementTree.Element('world', name='the world')
        frames.extend([*parent.findall('frame'), *(model for model, _, _ in found)])
        scope = Scope(frames, self._report)
        poses = []
        for model in filter(_is_relative, (model for model, _, _ in found)):
            with self._report.left_out():
                poses.append((model, scope.pose(model)))
        for model, pose in poses:
            sdf_frames.set_pose(model, pose)
        for each in found:
            self._add(*each, parent.find('state'))
        for light in parent.findall('state/light'):
            with self._report.left_out():
                if name_of(light) in self.lights:
                    self.lights[name_of(light)] = self.lights[name_of(light)]._replace(
                        pose=sdf_frames.pose_of(light))

    def _add(self, model: ElementTree.Element, version: Version, path: str,
             state: Optional[ElementTree.Element]) -> None:
        name = name_of(model)
        starts: Starts = {}
        if name in self._names:         # Gazebo does not insert it either
            self._report.add(NOT_USED, 'second model ' + name, path)
            return
        self._names.add(name)
        with self._report.left_out():
            starts = sdf_states.apply(model, state)
        if not self.has_floor and path == name == _GROUND_PLANE and _is_in_place(model):
            self.has_floor = True
            return
        with self._report.left_out():
            self.trees += sdf_models.trees(model, version, self._finder(path), self._report,
                                           starts)

    def _add_light(self, element: ElementTree.Element) -> None:
        # of two with one name, Gazebo ends
        self.lights.setdefault(name_of(element), sdf_links.light(element,
                                                                 sdf_frames.pose_of(element)))

    def _included(self, include: ElementTree.Element, path: str, stack: Sequence[str]
                  ) -> List[_Found]:
        """Return the model of an <include>, its version of SDF and its file; [] for a light.

        Raises SimulationError when it cannot be had.
        """
        uri = text_of(include, 'uri')
        built_in = _BUILT_IN.fullmatch(unquote(uri))
        if built_in:
            if built_in.group(1).lower() != _SUN:
                return [(_changed(parse_xml(_GROUND_PLANE_XML), include, ('pose', 'static')),
                         (1, 6), _GROUND_PLANE)]
            self.lights.setdefault(text_of(include, 'name') or _SUN,
                                   SUN._replace(pose=sdf_frames.pose_of(include)))
            return []
        if uri.startswith(_URLS):
            raise SimulationError('{} ({})'.format(uri, NOT_DOWNLOADED))
        found = self._finder(path)(uri)
        file = None if found is None else model_file(found)
        if file is None:
            raise SimulationError(uri or 'an <include> without a <uri>')
        self._check_include(file, stack)
        root = parsed(file)
        if file not in self._audited:
            self._audited.add(file)
            self._report.extend(audit.audit(root))
        model = root.find('model')
        if model is None:
            light = root.find('light')
            if light is None:
                raise SimulationError('{}, which it includes, has no <model>'.format(file))
            self._add_light(_changed(light, include, ('pose',)))
            return []
        self._expand(model, file, (*stack, file))
        return [(_changed(model, include, ('pose', 'static')), version_of(root), file)]

    def _check_include(self, file: str, stack: Sequence[str]) -> None:
        """Raise SimulationError unless a file can be included; stack: the files it stands in."""
        if file in stack:
            raise SimulationError('{} includes itself'.format(file), 'remove that <include>')
        self._included_count += 1
        if self._included_count > _MAX_INCLUDED:
            raise SimulationError('it includes more than {} models, at {}'.format(
                _MAX_INCLUDED, file), 'remove some <include>s')

    def _expand(self, model: ElementTree.Element, path: str, stack: Sequence[str]) -> None:
        """Replace each <include> in a model, at any depth; make the URIs in it absolute."""
        if self._depth >= _MAX_NESTED:
            raise SimulationError('models are nested more than {} deep, at {} in {}'.format(
                _MAX_NESTED, name_of(model), path), 'include the innermost ones directly')
        self._depth += 1
        inside = model.findall('model')         # those that are included are expanded already
        for include in model.findall('include'):
            model.remove(include)
            with self._report.left_out():
                for included, _, _ in self._included(include, path, stack):
                    included.set(INCLUDED, '1')
                    if value(included, 'static'):        # as in Gazebo
                        _replace(model, 'static', included)
                    model.append(included)
        for nested in inside:
            with self._report.left_out():
                self._expand(nested, path, stack)
        self._depth -= 1
        finder = self._finder(path)
        for element in model.iter():
            if element.tag in ('uri', 'filename') and element.text:
                found = finder(element.text.strip())
                if found is not None:
                    element.text = os.path.abspath(found)

    def _finder(self, path: str) -> FindFile:
        """Return a function that finds what a file refers to."""
        folder = os.path.dirname(os.path.abspath(path))
        relative = find_relative(folder, self._find)

        def find(uri: str) -> Optional[str]:
            found = relative(uri)
            if found is None and uri.startswith(_MODEL_URI):
                return find_above(folder, uri[len(_MODEL_URI):].lstrip('/'))
            return found
        return find


def _changed(element: ElementTree.Element, include: ElementTree.Element,
             tags: Sequence[str]) -> ElementTree.Element:
    """Return an element with the name and the children of some tags that an <include> gives."""
    for tag in tags:
        _replace(element, tag, include)
    element.set('name', text_of(include, 'name') or name_of(element))
    return element


def _replace(model: ElementTree.Element, tag: str, source: ElementTree.Element) -> None:
    """Give a model the element with a tag that another one has, if it has one."""
    given = source.find(tag)
    if given is not None:
        for old in model.findall(tag):
            model.remove(old)
        model.append(given)


def _is_relative(model: ElementTree.Element) -> bool:
    return any(pose.get('relative_to') or pose.get('frame') for pose in model.findall('pose'))


def _is_in_place(model: ElementTree.Element) -> bool:
    """Return whether a model stands at the origin of the world."""
    return bool(np.allclose(sdf_frames.pose_of(model).matrix(), np.eye(4), atol=1e-9))


def _road(road: ElementTree.Element, find: FindFile, report: Report) -> Tree:
    """Return a <road> as a tree without a collision shape, like in Gazebo.

    find: returns the path of the file at a URI; report: to which is added a look that is not
    found. Raises SimulationError when a number is wrong, or it has fewer than two points.
    """
    name = 'road {}'.format(name_of(road)).strip()
    points = np.array(values(road, 'point')).reshape(-1, 3)
    width = value(road, 'width')
    if len(points) < 2:
        raise SimulationError('{} has {} points, expected 2 or more'.format(name, len(points)))
    material = materials.of_sdf(road, find, report)
    above = IDENTITY._replace(translation=np.array((0.0, 0.0, _ABOVE_M)))
    strip = Look(Shape(MESH, (1.0, 1.0, 1.0), _strip(points, width)), above, material or _ASPHALT)
    name = road.get('name', 'road')
    return Tree(name, Model(name, (Link('link', looks=(strip,)),)), fixed=True)


def _strip(points: np.ndarray, width: float) -> str:
    """Write the mesh of a strip along points (n, 3); return its path."""
    steps = np.diff(points[:, :2], axis=0)
    lengths = np.maximum(np.linalg.norm(steps, axis=1), 1e-9)
    directions = steps / lengths[:, None]
    # at a corner, across the mean of both directions
    at_points = np.concatenate([directions[:1], directions[:-1] + directions[1:], directions[-1:]])
    across = np.column_stack([at_points[:, 1], -at_points[:, 0], np.zeros(len(points))])
    across /= np.maximum(np.linalg.norm(across, axis=1), 1e-9)[:, None]
    vertices = np.stack([points - across * width / 2, points + across * width / 2], axis=1)
    along = np.concatenate([[0.0], np.cumsum(lengths)]) / (width or 1.0)
    left, right = np.zeros(len(points)), np.ones(len(points))
    uvs = np.stack([np.column_stack([left, along]), np.column_stack([right, along])], axis=1)
    return generated_meshes.write(vertices.reshape(-1, 3),
                                  generated_meshes.grid_faces(len(points), 2), uvs.reshape(-1, 2))
