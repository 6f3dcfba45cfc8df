"""The links and joints of an SDF's model and of the models in it, by their full names."""
import math
import xml.etree.ElementTree as ElementTree
from typing import Callable, Dict, List, Mapping, NamedTuple, Optional, Sequence, Tuple

import numpy as np

from img_recog.errors import SimulationError
from img_recog.formats.reader import is_true, name_of, text_of, value
from img_recog.formats.sdf_frames import WORLD, Scope
from img_recog.formats.sdf_versions import Version
from img_recog.model import CONTINUOUS, FIXED, PRISMATIC, REVOLUTE
from img_recog.report import LEFT_OUT, NOT_USED, Report
from img_recog.rotations import IDENTITY, Transform

BALL, GEARBOX, SCREW, REVOLUTE2 = 'ball', 'gearbox', 'screw', 'revolute2'
_RATIOS = {GEARBOX: 'gearbox_ratio', SCREW: 'thread_pitch'}
# the axes of the kinds of joints: elements of an SDF's joint, or of the frame of a ball joint
_AXES: Dict[str, Sequence[str]] = {
    FIXED: (), PRISMATIC: ('axis',), REVOLUTE: ('axis',), CONTINUOUS: ('axis',),
    'universal': ('axis', 'axis2'), REVOLUTE2: ('axis', 'axis2'), BALL: (), SCREW: ('axis',),
    GEARBOX: ('axis', 'axis2')}
NO_LIMIT = 1e16                 # an SDF's number for that
INCLUDED = 'included'           # an attribute of a model that another one includes
# of <dynamics>, by the fields of a Joint
_DYNAMICS = {'damping': 'damping', 'friction': 'friction', 'stiffness': 'spring_stiffness',
             'reference': 'spring_reference'}


class SdfLink(NamedTuple):
    """A link by its full name; pose: in the outermost model; is_static: whether nothing moves it;
    space: see Link; scope: of the frames in it; can_sleep: see Model."""

    name: str
    element: ElementTree.Element
    pose: Transform
    is_static: bool
    space: str
    scope: Scope
    can_sleep: bool


class Axis(NamedTuple):
    """An axis of a joint, a unit vector (3,) in its frame; limits: from and to, in rad or m;
    dynamics: fields of a Joint; strength: of Limits; slides: whether the child slides along it."""

    direction: np.ndarray
    limits: Optional[Tuple[float, float]] = None
    dynamics: Mapping[str, float] = {}
    strength: Mapping[str, float] = {}
    slides: bool = False


class SdfJoint(NamedTuple):
    """A joint between links by their full names.

    parent: WORLD for none; pose: of its frame in the outermost model; axes: those about which the
    child turns, or along which it slides, the first one fixed to the parent; ratio: of a gearbox,
    or the pitch of a screw, in rad/m; reference: the link that bears a gearbox, '' for none.
    """

    name: str
    kind: str
    parent: str
    child: str
    pose: Transform
    axes: Tuple[Axis, ...]
    ratio: float = 1.0
    reference: str = ''

    def reversed(self) -> 'SdfJoint':
        """Return the same joint with the child as the parent."""
        return self._replace(parent=self.child, child=self.parent, axes=tuple(
            axis._replace(direction=-axis.direction) for axis in self.axes[::-1]))


class Joints:
    """The links and the joints of a model, in the order of the file.

    As in Gazebo, those of links and joints need not differ until SDF 1.6, and of links of one name
    the first is used. Of joints they are made to differ here.
    """

    def __init__(self, model: ElementTree.Element, version: Version, report: Report):
        """Read a model; report: to which is added what cannot be used of it."""
        self._version, self._report = version, report
        self.links: Dict[str, SdfLink] = {}
        self.joints: List[SdfJoint] = []
        self.gearboxes: List[SdfJoint] = []
        self._collect(model, '', IDENTITY, False)

    def _collect(self, model: ElementTree.Element, prefix: str, pose: Transform,
                 is_static: bool) -> None:
        """Add a model; pose: of its frame in the outermost one."""
        scope = Scope(model, self._report)
        # Gazebo makes what is included a part of the model, but not a model that is given in it
        is_static = value(model, 'static') or (
            is_static and is_true(model.get(INCLUDED)))
        for link in model.findall('link'):
            name = prefix + (link.get('name') or 'link')
            if name in self.links:
                self._report.add(NOT_USED, 'second link ' + name, name_of(model))
                continue
            with self._report.left_out():
                self.links[name] = SdfLink(
                    name, link, pose @ scope.pose(link),
                    is_static or value(link, 'kinematic'),
                    name if collides_with_all(link, model) else prefix,
                    Scope(link, self._report, scope),
                    link.find('sensor') is None and model.find('joint') is None
                    and value(model, 'allow_auto_disable'))
        for nested in model.findall('model'):
            with self._report.left_out():
                self._collect(nested, '{}{}::'.format(prefix, name_of(nested)),
                              pose @ scope.pose(nested), is_static)
        for joint in model.findall('joint'):
            with self._report.left_out():
                self._add_joint(joint, prefix, pose, model, scope)

    def _add_joint(self, element: ElementTree.Element, prefix: str, pose: Transform,
                   model: ElementTree.Element, scope: Scope) -> None:
        name = prefix + name_of(element)
        parent, child = (self._link_name(name, text_of(element, end), prefix, model)
                         for end in ('parent', 'child'))
        kind = element.get('type', '')
        if all(end == WORLD or self.links[end].is_static for end in (parent, child)):
            kind = FIXED        # what is static does not move
        elif kind not in _AXES:
            self._report.add(LEFT_OUT, 'joint {} of type {}, which is held'.format(name, kind))
            kind = FIXED
        joint_pose = pose @ scope.pose(element)
        owner = 'joint ' + name
        axes = tuple(Axis(self._direction(element, tag, pose, joint_pose, scope),
                          _limits(element, tag, owner), _dynamics(element, tag, owner),
                          _strength(element, tag, owner), kind == PRISMATIC)
                     for tag in _AXES[kind])
        if kind == BALL:
            axes = tuple(map(Axis, np.eye(3)))
        elif kind == CONTINUOUS:
            axes = tuple(axis._replace(limits=None) for axis in axes)
        elif kind == REVOLUTE2:     # as in ODE: the first one turns back, the second has no limits
            axes = (axes[0]._replace(direction=-axes[0].direction),
                    axes[1]._replace(limits=None))
        elif kind == SCREW:
            axes = (*axes, Axis(axes[0].direction, slides=True))
        name = _free_name(name, lambda each: any(each == other.name for other in self.joints))
        reference = element.findtext('gearbox_reference_body')
        joint = SdfJoint(
            name, kind, parent, child, joint_pose, axes,
            value(element, _RATIOS[kind], owner) if kind in _RATIOS else 1.0,
            self._link_name(name, reference, prefix, model) if reference else '')
        if kind == GEARBOX:
            self.gearboxes.append(joint)
        elif parent == child:
            self._report.add(
                NOT_USED, 'joint {}, which joins a link to itself,'.format(name), name_of(model))
        else:
            self.joints.append(joint.reversed() if child == WORLD else joint)

    def _link_name(self, joint: str, text: str, prefix: str, model: ElementTree.Element) -> str:
        """Return the full name of a link that a joint in a model names, maybe by a frame."""
        frames = {frame.get('name'): frame.get('attached_to', '') for frame in model.findall(
            'frame')}
        name = text
        for _ in range(len(frames)):
            name = frames.get(name, name)
        # a model may name its links by its own name first
        for found in (prefix + name, prefix + name.partition('::')[2]):
            if found in self.links:
                return found
        if name == WORLD:
            return WORLD
        raise SimulationError('joint {} has the link {}, which does not exist'.format(
            joint, prefix + text))

    def _direction(self, joint: ElementTree.Element, tag: str, model: Transform, pose: Transform,
                   scope: Scope) -> np.ndarray:
        """Return the direction of an axis of a joint in its frame."""
        axis = joint.find(tag)
        if axis is None:
            return np.array([0.0, 0.0, 1.0])
        direction = value(joint, tag + '/xyz')
        in_model = value(joint, tag + '/use_parent_model_frame')
        expressed = axis.find('xyz[@expressed_in]')     # since SDF 1.7
        base: Optional[Transform] = None
        if expressed is not None:
            name = expressed.get('expressed_in', '')
            frame = scope.frame(name, joint) if name else None
            base = frame and model @ frame
        elif in_model and self._version >= (1, 7):
            self._report.add(NOT_USED, '<use_parent_model_frame>, since SDF 1.7',
                             'joint ' + name_of(joint))         # as in Gazebo
        elif in_model or (in_model is None and self._version < (1, 5)):
            base = model        # until SDF 1.4 axes were given in the model's frame
        return direction if base is None else pose.rotation.T @ base.rotation @ direction


def _limits(joint: ElementTree.Element, axis: str, owner: str) -> Optional[Tuple[float, float]]:
    lower, upper = (value(joint, '{}/limit/{}'.format(axis, end), owner)
                    for end in ('lower', 'upper'))
    # as in Gazebo, those that are swapped are none
    if lower > upper or min(-lower, upper) >= NO_LIMIT:
        return None
    return max(lower, -NO_LIMIT), min(upper, NO_LIMIT)


def _strength(joint: ElementTree.Element, axis: str, owner: str) -> Dict[str, float]:
    found = {tag: value(joint, '{}/limit/{}'.format(axis, tag), owner)
             for tag in ('effort', 'velocity')}
    return {tag: each for tag, each in found.items() if 0 <= each < math.inf}


def _dynamics(joint: ElementTree.Element, axis: str, owner: str) -> Dict[str, float]:
    dynamics = {field: value(joint, '{}/dynamics/{}'.format(axis, tag), owner)
                for field, tag in _DYNAMICS.items()}
    return {**dynamics, 'damping': abs(dynamics['damping'])}        # as in Gazebo


def collides_with_all(link: ElementTree.Element, model: ElementTree.Element) -> bool:
    """Return whether a link meets the others of its model: what it says counts, else the model."""
    own = value(link, 'self_collide')
    return value(model, 'self_collide') if own is None else own


def _free_name(name: str, is_used: Callable[[str], bool]) -> str:
    number, free = 0, name
    while is_used(free):
        number += 1
        free = '{}_{}'.format(name, number)
    return free
