"""The models of an SDF as trees of links, each the text of a URDF."""
import xml.etree.ElementTree as ElementTree
from typing import Dict, List, NamedTuple, Optional, Set, Tuple

import numpy as np

from img_recog.files import FindFile
from img_recog.simulation.descriptions import meshes, sdf_links
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform
from img_recog.simulation.descriptions.numbers import read_direction, read_number, words
from img_recog.simulation.descriptions.sdf_frames import WORLD, Scope, pose_of
from img_recog.simulation.descriptions.urdf_elements import add_massless, set_origin
from img_recog.simulation.settings import SimulationError

_JOINTS = ('continuous', 'fixed', 'prismatic', 'revolute')
_MAX_JOINT_LIMIT = 1e16         # an SDF's number for no limit

Version = Tuple[int, ...]       # of the SDF format, like (1, 6)


class Tree(NamedTuple):
    """Links that are joined to one root.

    name: of the model, with ::LINK for the roots after the first; urdf: its text, in which all
    meshes have absolute paths; pose: of the root link in the world; fixed: whether that never
    moves; in_model: the pose of the root link in the frame of the model; first: whether it is the
    first tree of its model; warnings: what is simulated in another way than given, a line each.
    """

    name: str
    urdf: str
    pose: Transform
    fixed: bool
    in_model: Transform = IDENTITY
    first: bool = True
    warnings: Tuple[str, ...] = ()


class _Link(NamedTuple):
    """A link by its full name; pose: in the outermost model."""

    name: str
    element: ElementTree.Element
    pose: Transform
    is_static: bool


class _Joint(NamedTuple):
    """A joint between links by their full names; pose: of its frame in the outermost model."""

    name: str
    element: ElementTree.Element
    parent: str
    child: str
    pose: Transform
    axis: np.ndarray


def trees(model: ElementTree.Element, version: Version, find: FindFile,
          missing: List[str]) -> List[Tree]:
    """Return the trees of a model.

    version: of the SDF format. find: returns the path of the file or folder at a URI. missing: to
    which is appended what cannot be had, by name.
    Raises SimulationError when a number is wrong, or a joint or a pose names nothing.
    """
    name = model.get('name', '')
    builder = _Builder(version, find, missing)
    pose = pose_of(model)
    builder.collect(model, '', IDENTITY, False)
    if not builder.links:
        raise SimulationError('model {} has no link'.format(name), 'add a <link> to it')
    return builder.trees(name, pose)


def is_true(text: Optional[str]) -> bool:
    """Return whether the text of an element means true."""
    return (text or '').strip().lower() in ('1', 'true')


class _Builder:
    """Collects the links and joints of a model and of those in it, and builds the trees."""

    def __init__(self, version: Version, find: FindFile, missing: List[str]):
        self._version, self._find, self._missing = version, find, missing
        self.links: Dict[str, _Link] = {}
        self._warnings: List[str] = []      # of the tree that is being built
        self._joints: List[_Joint] = []

    def collect(self, model: ElementTree.Element, prefix: str, pose: Transform,
                is_static: bool) -> None:
        """Add a model; pose: of its frame in the outermost one."""
        scope = Scope(model)
        is_static = is_static or is_true(model.findtext('static'))
        for link in model.findall('link'):
            name = prefix + link.get('name', '')
            if not link.get('name') or name in self.links:
                raise SimulationError('each <link> of model {} must have a unique name'.format(
                    model.get('name', '')))
            self.links[name] = _Link(name, link, pose @ scope.pose(link), is_static)
        for nested in model.findall('model'):
            self.collect(nested, '{}{}::'.format(prefix, nested.get('name', '')),
                         pose @ scope.pose(nested), is_static)
        for joint in model.findall('joint'):
            self._add_joint(joint, prefix, pose, scope)

    def _add_joint(self, element: ElementTree.Element, prefix: str, pose: Transform,
                   scope: Scope) -> None:
        name = prefix + element.get('name', '')
        if element.get('type') not in _JOINTS:
            self._missing.append('joint {} of type {}'.format(name, element.get('type')))
            return
        parent, child = (element.findtext(end, '').strip() for end in ('parent', 'child'))
        parent = parent if parent == WORLD else prefix + parent
        child = prefix + child
        for end in (parent, child):
            if end != WORLD and end not in self.links:
                raise SimulationError('joint {} has the link {}, which does not exist'.format(
                    name, end))
        if any(child == other.child for other in self._joints):
            raise SimulationError('link {} is the child of two joints'.format(child))
        joint_pose = pose @ scope.pose(element)
        self._joints.append(_Joint(name, element, parent, child, joint_pose,
                                   self._axis(element, pose, joint_pose)))

    def _axis(self, joint: ElementTree.Element, model: Transform, pose: Transform) -> np.ndarray:
        """Return the axis of a joint in its frame."""
        axis = joint.find('axis')
        if axis is None:
            return np.array([0.0, 0.0, 1.0])
        direction = read_direction('<xyz> of joint ' + joint.get('name', ''),
                                   axis.findtext('xyz', '0 0 1'))
        in_model = axis.findtext('use_parent_model_frame')
        expressed = axis.find('xyz[@expressed_in="__model__"]')     # since SDF 1.7
        # until SDF 1.4 axes were given in the model's frame
        if expressed is not None or is_true(in_model) or (
                in_model is None and self._version < (1, 5)):
            direction = pose.rotation.T @ model.rotation @ direction
        return direction

    def trees(self, name: str, pose: Transform) -> List[Tree]:
        """Return the trees; pose: of the outermost model in the world."""
        joined = {joint.child for joint in self._joints if joint.parent != WORLD}
        found: List[Tree] = []
        seen: Set[str] = set()
        for link in self.links.values():
            if link.name not in joined:
                tree = self._tree(name, link, pose, seen)
                found.append(tree._replace(name='{}::{}'.format(name, link.name), first=False)
                             if found else tree)
        if len(seen) < len(self.links):
            raise SimulationError('model {}: link {} is its own ancestor'.format(
                name, min(set(self.links) - seen)))
        return found

    def _tree(self, name: str, root: _Link, pose: Transform, seen: Set[str]) -> Tree:
        robot = ElementTree.Element('robot', name=name)
        to_world = next((joint for joint in self._joints
                         if joint.child == root.name and joint.parent == WORLD), None)
        is_fixed = root.is_static or (
            to_world is not None and to_world.element.get('type') == 'fixed')
        frames = {root.name: root.pose}
        if to_world is not None and not is_fixed:
            # the joint needs a parent
            add_massless(ElementTree.SubElement(robot, 'link', name=WORLD))
            frames = {root.name: to_world.pose}
            base = to_world.pose
            self._add_joint_element(robot, to_world, IDENTITY, parent=WORLD)
        else:
            base = root.pose
        names, self._warnings = [root.name], []
        for link in names:          # grows while it is iterated over
            seen.add(link)
            self._add_link(robot, self.links[link], frames[link], is_fixed and link == root.name)
            for joint in self._joints:
                if joint.parent == link and joint.child not in frames:
                    frames[joint.child] = joint.pose
                    names.append(joint.child)
                    self._add_joint_element(robot, joint, _relative(frames[link], joint.pose))
        return Tree(name, ElementTree.tostring(robot, 'unicode'), pose @ base,
                    is_fixed or base is not root.pose, base, warnings=tuple(self._warnings))

    def _add_link(self, robot: ElementTree.Element, link: _Link, frame: Transform,
                  is_fixed: bool) -> None:
        """Add a link whose frame in the URDF is `frame`, given in the outermost model."""
        added = ElementTree.SubElement(robot, 'link', name=link.name)
        offset = _relative(frame, link.pose)
        if is_fixed or link.is_static:
            add_massless(added)
        else:
            warning = sdf_links.add_inertial(added, link.element, offset)
            self._warnings += [warning] if warning else []
        sdf_links.add_friction(added, link.element)
        scope = Scope(link.element)
        for tag in ('visual', 'collision'):
            for shape in link.element.findall(tag):
                missing = sdf_links.add_shape(added, shape, offset @ scope.pose(shape), self._find,
                                              concave=is_fixed or link.is_static)
                if missing and missing not in self._missing:
                    self._missing.append(missing)
        for tag, other in (('visual', 'collision'), ('collision', 'visual')):
            if link.element.find(tag) is not None and added.find(tag) is None:
                meshes.add_replacements(added, tag, added.findall(other))

    def _add_joint_element(self, robot: ElementTree.Element, joint: _Joint, pose: Transform,
                           parent: str = '') -> None:
        # the links of a static model do not move, and have no mass
        kind = 'fixed' if self.links[joint.child].is_static else joint.element.get('type', '')
        element = ElementTree.SubElement(robot, 'joint', name=joint.name, type=kind)
        set_origin(element, pose)
        ElementTree.SubElement(element, 'parent', link=parent or joint.parent)
        ElementTree.SubElement(element, 'child', link=joint.child)
        if kind == 'fixed':
            return
        ElementTree.SubElement(element, 'axis', xyz=words(joint.axis))
        limit = joint.element.find('axis/limit')
        if limit is not None and kind != 'continuous':
            lower, upper = (read_number(
                '<{}> of joint {}'.format(tag, joint.name), limit.findtext(tag, default))
                for tag, default in (('lower', '-1e16'), ('upper', '1e16')))
            if max(-lower, upper) >= _MAX_JOINT_LIMIT and kind == 'revolute':
                element.set('type', 'continuous')
            else:
                ElementTree.SubElement(element, 'limit', lower=repr(lower), upper=repr(upper),
                                       effort='1e9', velocity='1e9')
        elif kind == 'revolute':
            element.set('type', 'continuous')


def _relative(frame: Transform, pose: Transform) -> Transform:
    """Return a pose in a frame, both given in the same one."""
    turn = frame.rotation.T
    return Transform(turn @ pose.rotation, turn @ (pose.translation - frame.translation))
