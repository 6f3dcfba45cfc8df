"""The models of an SDF as trees of links, each the text of a URDF."""
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterator, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog.files import FindFile
from img_recog.simulation.descriptions import meshes, sdf_links
from img_recog.simulation.descriptions.geometry import IDENTITY, Transform
from img_recog.simulation.descriptions.numbers import words
from img_recog.simulation.descriptions.problems import Problems
from img_recog.simulation.descriptions.sdf_frames import WORLD, Scope, pose_of
from img_recog.simulation.descriptions.sdf_joints import (
    FIXED, PRISMATIC, Axis, Joint, Joints, Link, Version)
from img_recog.simulation.descriptions.texts import name_of
from img_recog.simulation.descriptions.urdf_elements import add_massless, set_origin

_FAR_M = 1e16


class Loop(NamedTuple):
    """A joint that closes a loop of links: a tree has no place for it.

    parent: WORLD for none; pose: of the joint in the frame of the root link; axis (3,): the only
    one about which it turns, in its frame, None without.
    """

    kind: str
    parent: str
    child: str
    pose: Transform
    axis: Optional[np.ndarray]


class Tree(NamedTuple):
    """Links that are joined to one root.

    name: of the model, with ::LINK for the roots after the first; urdf: its text, in which all
    meshes have absolute paths; pose: of the root link in the world; fixed: whether that never
    moves; in_model: the pose of the root link in the frame of the model; first: whether it is the
    first tree of its model; warnings: what is simulated in another way than given, a line each;
    loops: the joints that the URDF has not; is_terrain: whether it is a heightmap that carries;
    frames: the pose of each link of the model in the link of that name in the URDF.
    """

    name: str
    urdf: str
    pose: Transform
    fixed: bool
    in_model: Transform = IDENTITY
    first: bool = True
    warnings: Tuple[str, ...] = ()
    loops: Tuple[Loop, ...] = ()
    is_terrain: bool = False
    frames: Mapping[str, Transform] = {}


def trees(model: ElementTree.Element, version: Version, find: FindFile,
          problems: Problems) -> List[Tree]:
    """Return the trees of a model, none for one without a link.

    version: of the SDF format. find: returns the path of the file or folder at a URI. problems: to
    which is added what cannot be used, a number, a joint or a shape; the rest is in the trees.
    Raises SimulationError when the pose of the model cannot be used.
    """
    name, pose = name_of(model), pose_of(model)
    parts = Joints(model, version, problems)
    found: List[Tree] = []
    joints_of = _joints_of_links(parts)
    for root in _roots(parts):
        for tree in _Builder(parts, joints_of, root, find, problems).trees(name, pose):
            found.append(tree._replace(first=False) if found else tree._replace(name=name))
    return found


def _roots(parts: Joints) -> List[Link]:
    """Return a root for each group of links that joints hold together.

    That is one that does not move, else one that a joint ties to the world, else one that is the
    child of no joint, else the first one.
    """
    groups = {name: [name] for name in parts.links}     # those of a group are the same list
    for joint in parts.joints:
        if joint.parent != WORLD and groups[joint.parent] is not groups[joint.child]:
            first, second = groups[joint.parent], groups[joint.child]
            first += second
            groups.update(dict.fromkeys(second, first))
    tied = {joint.child for joint in parts.joints if joint.parent == WORLD}
    joined = {joint.child for joint in parts.joints}
    order = {name: number for number, name in enumerate(parts.links)}
    unique = {id(group): group for group in groups.values()}
    return [parts.links[min(group, key=lambda name: (
        not parts.links[name].is_static, name not in tied, name in joined, order[name]))]
            for group in unique.values()]


def _joints_of_links(parts: Joints) -> Dict[str, List[Joint]]:
    """Return the joints of each link, those to its parent and those to its children."""
    found: Dict[str, List[Joint]] = {name: [] for name in parts.links}
    for joint in parts.joints:
        found[joint.child].append(joint)
        if joint.parent != WORLD:
            found[joint.parent].append(joint)
    return found


class _Builder:
    """Builds the tree of the links that hang on a root, whichever way their joints point."""

    def __init__(self, parts: Joints, joints_of: Dict[str, List[Joint]], root: Link,
                 find: FindFile, problems: Problems):
        self._links, self._of_links, self._root = parts.links, joints_of, root
        self._find, self._problems = find, problems
        self._warnings: List[str] = []
        self._terrains: List[Tree] = []

    def trees(self, name: str, model_pose: Transform) -> List[Tree]:
        """Return the tree, and one for each terrain; model_pose: of the outermost model."""
        robot, root = ElementTree.Element('robot', name=name), self._root
        to_world = next((joint for joint in self._of_links[root.name] if joint.parent == WORLD),
                        None)
        is_fixed = root.is_static or (to_world is not None and to_world.kind == FIXED)
        base, frames = root.pose, {root.name: root.pose}
        used = [] if to_world is None else [to_world]
        if to_world is not None and not is_fixed:
            # the joint needs a parent
            add_massless(ElementTree.SubElement(robot, 'link', name=WORLD))
            base, frames = to_world.pose, {root.name: to_world.pose}
            _add_joint(robot, to_world, IDENTITY)
        names, loops = [root.name], []
        for link in names:          # grows while it is iterated over
            self._add_link(robot, self._links[link], frames[link], is_fixed and link == root.name)
            for joint in self._of_links[link]:
                if any(joint is each for each in used):
                    continue
                used.append(joint)
                away = joint if joint.parent in (link, WORLD) else joint.reversed()
                if away.parent == WORLD or away.child in frames:
                    loops.append(joint)
                    continue
                frames[away.child] = joint.pose
                names.append(away.child)
                _add_joint(robot, away, _relative(frames[link], joint.pose))
        tree = Tree('{}::{}'.format(name, root.name), ElementTree.tostring(robot, 'unicode'),
                    model_pose @ base, is_fixed or base is not root.pose, base,
                    warnings=tuple(self._warnings), loops=tuple(self._loops(loops, base)),
                    frames={link: _relative(frames[link], self._links[link].pose)
                            for link in names})
        return [tree, *(each._replace(name='{}::{}'.format(name, each.name),
                                      pose=model_pose @ each.in_model) for each in self._terrains)]

    def _loops(self, joints: Sequence[Joint], base: Transform) -> Iterator[Loop]:
        for joint in joints:
            if all(end == WORLD or self._links[end].is_static
                   for end in (joint.parent, joint.child)):
                continue
            if joint.kind == PRISMATIC:
                self._problems.add('joint {}, which closes a loop of links and slides'.format(
                    joint.name))
                continue
            yield Loop(joint.kind, joint.parent, joint.child, _relative(base, joint.pose),
                       joint.axes[0].direction if len(joint.axes) == 1 else None)

    def _add_link(self, robot: ElementTree.Element, link: Link, frame: Transform,
                  is_fixed: bool) -> None:
        """Add a link whose frame in the URDF is `frame`, given in the outermost model."""
        added = ElementTree.SubElement(robot, 'link', name=link.name)
        offset = _relative(frame, link.pose)
        if is_fixed or link.is_static:
            add_massless(added)
        else:
            warning = self._add_inertial(added, link.element, offset)
            self._warnings += [warning] if warning else []
        with self._problems.left_out():
            sdf_links.add_friction(added, link.element)
        scope = Scope(link.element)
        for tag in ('visual', 'collision'):
            for shape in link.element.findall(tag):
                with self._problems.left_out():
                    if sdf_links.is_terrain(shape):
                        self._add_terrain(link, shape, scope)
                        continue
                    look = sdf_links.add_shape(
                        added, shape, offset @ scope.pose(shape), self._find,
                        concave=is_fixed or link.is_static)
                    if look:
                        self._problems.add_look(look)
        for tag, other in (('visual', 'collision'), ('collision', 'visual')):
            given = [shape for shape in link.element.findall(tag)
                     if not sdf_links.is_terrain(shape)]
            if given and added.find(tag) is None:
                meshes.add_replacements(added, tag, added.findall(other))

    def _add_terrain(self, link: Link, shape: ElementTree.Element, scope: Scope) -> None:
        robot = ElementTree.Element('robot', name=link.name)
        # PyBullet's name for the link of such a body
        added = ElementTree.SubElement(robot, 'link', name='link0')
        sdf_links.add_friction(added, link.element)
        pose = link.pose @ scope.pose(shape) @ sdf_links.add_terrain(added, shape, self._find)
        self._terrains.append(Tree('{}::{}'.format(link.name, name_of(shape)),
                                   ElementTree.tostring(robot, 'unicode'), pose, True, pose,
                                   is_terrain=True))

    def _add_inertial(self, added: ElementTree.Element, link: ElementTree.Element,
                      offset: Transform) -> str:
        with self._problems.left_out():
            return sdf_links.add_inertial(added, link, offset)
        # one without has that of SDF
        return sdf_links.add_inertial(added, ElementTree.Element('link'), offset)


def _add_joint(robot: ElementTree.Element, joint: Joint, pose: Transform) -> None:
    """Add a joint, with a massless link between two axes.

    pose: of the frame of the joint in that of its parent.
    """
    parent, axes = joint.parent, joint.axes or (None,)
    for number, axis in enumerate(axes, 1):
        child = name = '{}::axis_{}'.format(joint.name, number)
        if number == len(axes):
            child, name = joint.child, joint.name
        else:
            add_massless(ElementTree.SubElement(robot, 'link', name=child))
        element = ElementTree.SubElement(robot, 'joint', name=name, type=FIXED)
        set_origin(element, pose)
        ElementTree.SubElement(element, 'parent', link=parent)
        ElementTree.SubElement(element, 'child', link=child)
        if axis is not None:
            _set_axis(element, joint.kind, axis)
        parent, pose = child, IDENTITY


def _set_axis(element: ElementTree.Element, kind: str, axis: Axis) -> None:
    ElementTree.SubElement(element, 'axis', xyz=words(axis.direction))
    limits = axis.limits
    if kind == PRISMATIC:       # which PyBullet does not read without
        limits = limits or (-_FAR_M, _FAR_M)
    element.set('type', kind if kind == PRISMATIC else 'revolute' if limits else 'continuous')
    if limits is not None:
        ElementTree.SubElement(element, 'limit', lower=repr(limits[0]), upper=repr(limits[1]),
                               effort='1e9', velocity='1e9')


def _relative(frame: Transform, pose: Transform) -> Transform:
    """Return a pose in a frame, both given in the same one."""
    turn = frame.rotation.T
    return Transform(turn @ pose.rotation, turn @ (pose.translation - frame.translation))
