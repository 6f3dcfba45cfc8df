"""The models of an SDF as trees of links."""
import dataclasses
import xml.etree.ElementTree as ElementTree
from typing import Dict, Iterable, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from img_recog.files import FindFile
from img_recog.formats import lumping, sdf_links, sdf_states
from img_recog.formats.reader import name_of, value
from img_recog.formats.sdf_frames import WORLD, pose_of
from img_recog.formats.sdf_joints import NO_LIMIT, SCREW, Axis, Joints, SdfJoint, SdfLink
from img_recog.formats.sdf_states import Starts
from img_recog.formats.sdf_versions import Version
from img_recog.model import (CONTINUOUS, FIXED, HEIGHTMAP, NO_INERTIA, PLANE, PRISMATIC, REVOLUTE,
                             AttachedFrame, Gear, Inertia, Joint, Light, Limits, Link, Look, Model,
                             Solid, Tag, Tree)
from img_recog.report import NOT_SIMULATED, Report
from img_recog.rotations import IDENTITY, Transform

_PARALLEL = 0.999       # the cosine of an angle
BETWEEN_AXES = '::axis_'        # in the name of a link and a joint that stand for one of several


def trees(model: ElementTree.Element, version: Version, find: FindFile,
          report: Report, starts: Starts = {}) -> List[Tree]:
    """Return the trees of a model, none for one without a link.

    version: of the SDF format. find: returns the path of the file or folder at a URI. report: to
    which is added what cannot be used, a number, a joint or a shape; the rest is in the trees.
    starts: where links are at the start. Raises SimulationError when the pose of the model cannot
    be used.
    """
    name, pose = name_of(model), pose_of(model)
    parts = Joints(model, version, report)
    found: List[Tree] = []
    joints_of = _joints_of_links(parts)
    for root in _roots(parts):
        for tree in _Builder(parts, joints_of, root, find, report).trees(name, pose):
            found.append(tree._replace(first=False) if found else _with_plugins(
                tree._replace(name=name), model))
    return [sdf_states.started(tree, starts, pose) for tree in found]


def _with_plugins(tree: Tree, model: ElementTree.Element) -> Tree:
    """Return the first tree of a model with the plugins of the model and of those in it."""
    tags = tuple(Tag('', each) for each in model.iter('model') if each.find('plugin') is not None)
    return tree._replace(model=dataclasses.replace(tree.model, tags=(*tags, *tree.model.tags)))


def _roots(parts: Joints) -> List[SdfLink]:
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


def _joints_of_links(parts: Joints) -> Dict[str, List[SdfJoint]]:
    """Return the joints of each link, those to its parent and those to its children."""
    found: Dict[str, List[SdfJoint]] = {name: [] for name in parts.links}
    for joint in parts.joints:
        found[joint.child].append(joint)
        if joint.parent != WORLD:
            found[joint.parent].append(joint)
    return found


class _Builder:
    """Builds the tree of the links that hang on a root, whichever way their joints point."""

    def __init__(self, parts: Joints, joints_of: Dict[str, List[SdfJoint]], root: SdfLink,
                 find: FindFile, report: Report):
        self._given, self._of_links, self._root = parts.links, joints_of, root
        self._boxes = parts.gearboxes
        self._find, self._report = find, report
        self._links: List[Link] = []
        self._joints: List[Joint] = []
        self._turning: Dict[str, SdfJoint] = {}     # those with one axis
        self._gears: List[Gear] = []
        self._grounds: List[Tuple[Tree, Optional[np.ndarray]]] = []     # with normals of planes

    def trees(self, name: str, model_pose: Transform) -> List[Tree]:
        """Return the tree, and one for each terrain and plane; model_pose: of the outermost model.
        """
        root, self._name = self._root, name
        to_world = next((joint for joint in self._of_links[root.name] if joint.parent == WORLD),
                        None)
        is_fixed = root.is_static or (to_world is not None and to_world.kind == FIXED)
        base, frames = root.pose, {root.name: root.pose}
        used = [] if to_world is None else [to_world]
        if to_world is not None and not is_fixed:
            # the joint needs a parent
            self._links.append(Link(WORLD))
            base, frames = to_world.pose, {root.name: to_world.pose}
            self._add_joint(to_world, IDENTITY)
        names = [root.name]
        for link in names:          # grows while it is iterated over
            self._add_link(self._given[link], frames[link], is_fixed and link == root.name)
            for joint in self._of_links[link]:
                if any(joint is each for each in used):
                    continue
                used.append(joint)
                away = joint if joint.parent in (link, WORLD) else joint.reversed()
                if away.parent == WORLD or away.child in frames:
                    self._leave_open(joint)
                    continue
                frames[away.child] = joint.pose
                names.append(away.child)
                self._add_joint(away, _relative(frames[link], joint.pose))
        gears = _gears_of_boxes((box for box in self._boxes if box.child in frames),
                                self._turning, root.name if is_fixed else None, name,
                                self._report)
        tags = tuple(Tag(link, self._given[link].element) for link in names
                     if self._given[link].element.find('sensor') is not None)
        model = Model(name, tuple(self._links), tuple(self._joints),
                      {link: AttachedFrame(link, _relative(frames[link], self._given[link].pose))
                       for link in names}, {tag.link: (tag.link,) for tag in tags}, tags,
                      held=tuple(joint.name for joint in used if joint.kind == FIXED),
                      gears=(*self._gears, *gears), can_sleep=root.can_sleep and not used)
        tree = Tree('{}::{}'.format(name, root.name), lumping.divided(model), model_pose @ base,
                    is_fixed or base is not root.pose, base)
        return [tree, *(_placed(*each, name, model_pose) for each in self._grounds)]

    def _leave_open(self, joint: SdfJoint) -> None:
        """Say that a joint has no place in the tree, unless it joins what does not move."""
        if not all(end == WORLD or self._given[end].is_static
                   for end in (joint.parent, joint.child)):
            self._report.add(NOT_SIMULATED, 'joint {}, which closes a loop of links,'.format(
                joint.name), 'model ' + self._name)

    def _add_link(self, link: SdfLink, frame: Transform, is_fixed: bool) -> None:
        """Add a link whose frame in the model is `frame`, given in the outermost model."""
        offset = _relative(frame, link.pose)
        is_fixed = is_fixed or link.is_static
        inertia = NO_INERTIA if link.is_static else self._inertia(link.element, offset)
        decay = 0.0, 0.0
        with self._report.left_out():
            decay = sdf_links.decay(link.element)
        scope = link.scope
        looks: List[Look] = []
        for visual in link.element.findall('visual'):
            with self._report.left_out():
                looks.append(sdf_links.look(visual, offset @ scope.pose(visual), self._find,
                                            self._report))
        lamps: List[Light] = []
        for light in link.element.findall('light'):
            with self._report.left_out():
                lamps.append(sdf_links.light(light, offset @ scope.pose(light)))
        solids: List[Solid] = []
        for collision in link.element.findall('collision'):
            with self._report.left_out():
                solid = sdf_links.solid(collision, IDENTITY, self._find)
                with self._report.left_out():
                    solid = solid._replace(
                        friction=sdf_links.friction_of(collision, link.name),
                        contact=sdf_links.contact_of(collision, link.name, lambda _: None))
                solid = solid.moved(scope.pose(collision))
                if solid.shape.kind in (HEIGHTMAP, PLANE):
                    self._add_ground(link, collision, solid)
                else:
                    solids.append(solid.moved(offset)._replace(is_concave=is_fixed))
        # in place of shapes of which none can be had
        if not looks and link.element.find('visual') is not None:
            looks = [Look(solid.shape, solid.pose) for solid in solids]
        elif not solids and len(link.element.findall('collision')) > _count_grounds(link.element):
            solids = [Solid(look.shape, look.pose) for look in looks if look.shape.kind != PLANE]
        self._links.append(Link(link.name, inertia, tuple(solids), tuple(looks),
                                has_gravity=value(link.element, 'gravity'),
                                decay=decay, space=link.space, lights=tuple(lamps)))

    def _add_ground(self, link: SdfLink, collision: ElementTree.Element, solid: Solid) -> None:
        """Add the tree of a heightmap or a plane that carries; solid: at its pose in the link."""
        name = '{}::{}'.format(link.name, name_of(collision))
        # PyBullet's name for the link of such a body
        ground = Link('link0', solids=(solid._replace(pose=IDENTITY),))
        tree = Tree(name, Model(link.name, (ground,)), link.pose @ solid.pose, True)
        self._grounds.append((tree, sdf_links.normal(collision)))

    def _inertia(self, link: ElementTree.Element, offset: Transform) -> Inertia:
        with self._report.left_out():
            return sdf_links.inertia(link, offset, self._report)
        # in place of one that cannot be used, that of a link without
        return sdf_links.inertia(ElementTree.Element('link'), offset, self._report)

    def _add_joint(self, joint: SdfJoint, pose: Transform) -> None:
        """Add a joint, with a massless link between two axes.

        pose: of the frame of the joint in that of its parent.
        """
        if len(joint.axes) == 1 and not joint.axes[0].slides:
            self._turning[joint.name] = joint
        given, count = joint, len(self._joints)
        for number, axis in enumerate(joint.axes[:-1], 1):
            between = '{}{}{}'.format(joint.name, BETWEEN_AXES, number)
            self._links.append(Link(between))
            self._joints.append(_joint(joint, pose, axis)._replace(
                name=between, child=between))
            joint, pose = joint._replace(parent=between), IDENTITY
        self._joints.append(_joint(joint, pose, joint.axes[-1] if joint.axes else None))
        if joint.kind == SCREW:
            self._gears.append(_gear_of_screw(given, self._joints[count:]))


def _placed(ground: Tree, normal: Optional[np.ndarray], name: str, model: Transform) -> Tree:
    """Return the tree of a heightmap or a plane in the world, of a model of that name and pose.

    As in Gazebo, no pose turns a plane, and only its height moves it: that is the constant of its
    equation, in which its normal is as long as given.
    """
    pose = model @ ground.pose
    if normal is not None:
        pose = Transform(sdf_links.turn_z_to(normal / np.linalg.norm(normal)),
                         normal * pose.translation[2] / (normal @ normal))
    return ground._replace(name='{}::{}'.format(name, ground.name), pose=pose,
                           in_model=_relative(model, pose))


def _joint(joint: SdfJoint, pose: Transform, axis: Optional[Axis]) -> Joint:
    """Return the part of a joint that has one of its axes, None if it is fixed."""
    if axis is None:
        return Joint(joint.name, FIXED, joint.parent, joint.child, pose)
    limits, kind = axis.limits, PRISMATIC
    if axis.slides:         # which PyBullet does not read without limits
        limits = limits or (-NO_LIMIT, NO_LIMIT)
    else:
        kind = REVOLUTE if limits else CONTINUOUS
    return Joint(joint.name, kind, joint.parent, joint.child, pose, axis.direction,
                 Limits(*(limits or (-NO_LIMIT, NO_LIMIT)), **axis.strength)
                 if limits or axis.strength else None, **axis.dynamics)


def _count_grounds(link: ElementTree.Element) -> int:
    return sum(len(link.findall('collision/geometry/' + kind)) for kind in (HEIGHTMAP, PLANE))


def _relative(frame: Transform, pose: Transform) -> Transform:
    """Return a pose in a frame, both given in the same one."""
    turn = frame.rotation.T
    return Transform(turn @ pose.rotation, turn @ (pose.translation - frame.translation))


def _gear_of_screw(joint: SdfJoint, parts: Sequence[Joint]) -> Gear:
    """Return the gear of a screw, of which the parts turn and slide: as in Gazebo, it slides by
    the angle divided by the negative pitch."""
    slides, = (part.name for part in parts if part.kind == PRISMATIC)
    turns, = (part.name for part in parts if part.kind != PRISMATIC)
    return Gear(turns, slides, joint.ratio)


def _gears_of_boxes(boxes: Iterable[SdfJoint], joints: Mapping[str, SdfJoint], root: Optional[str],
                    model: str, report: Report) -> List[Gear]:
    """Return the gears of the gearboxes of a tree.

    joints: those of the tree with one axis that turns, by name, as the tree has them; root: of
    the tree, if that is fixed: it bears a gearbox without a link that does. report: to which
    the others are added.
    """
    gears = []
    for box in boxes:
        # as in Gazebo, the first axis is that of the child
        child, parent = (_wheel(joints, link, box.reference or root or '', turn)
                         for link, turn in zip((box.child, box.parent), (
                             box.pose.rotation @ axis.direction for axis in box.axes)))
        if child is None or parent is None:
            report.add(NOT_SIMULATED, 'joint {} of type {}, of which the links do not turn about '
                       'its axes'.format(box.name, box.kind), 'model ' + model)
        else:
            gears.append(Gear(child[0], parent[0], box.ratio * child[1] * parent[1]))
    return gears


def _wheel(joints: Mapping[str, SdfJoint], link: str, reference: str,
           axis: np.ndarray) -> 'Optional[tuple[str, int]]':
    """Return the joint by which a link turns against another one, and whether that is along the
    axis (3,) in the model, 1, or against it, -1."""
    for name, joint in joints.items():
        if {joint.parent, joint.child} == {link, reference}:
            turned = joint.pose.rotation @ joint.axes[0].direction
            along = turned @ axis / np.linalg.norm(turned) / np.linalg.norm(axis)
            if abs(along) > _PARALLEL:
                return name, (1 if along > 0 else -1) * (1 if joint.child == link else -1)
    return None
