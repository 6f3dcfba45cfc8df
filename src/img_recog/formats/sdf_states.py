"""The <state> of an SDF world: where its models and links are at the start."""
import xml.etree.ElementTree as ElementTree
from typing import Mapping, Optional

import numpy as np

from img_recog.formats.reader import name_of, read, text_of, value, words
from img_recog.formats.sdf_frames import pose_of, set_pose
from img_recog.model import PRISMATIC, Joint, Tree
from img_recog.rotations import Transform

Starts = Mapping[str, Transform]


def apply(model: ElementTree.Element, state: Optional[ElementTree.Element]) -> Starts:
    """Move a model to where the <state> of its world has it, as in Gazebo.

    Returns the poses of its links in the world that the state gives, by name.
    """
    starts: Starts = {}
    for each in () if state is None else state.findall('model'):
        if each.get('name') == model.get('name'):
            set_pose(model, pose_of(each))
            starts = _started(model, each)
    return starts


def _started(model: ElementTree.Element, state: ElementTree.Element, prefix: str = '') -> Starts:
    """Resize the shapes of a model, and return where the links of it and of those in it are."""
    scale = read('3lengths', text_of(state, 'scale') or '1 1 1',
                 '<scale> of model ' + name_of(model))
    for part in ('collision', 'visual'):
        for geometry in model.iterfind('link/{}/geometry'.format(part)):
            _resize(geometry, scale)
    starts = {prefix + name_of(link): pose_of(link) for link in state.findall('link')
              if link.find('pose') is not None}
    within = {name_of(nested): nested for nested in model.findall('model')}
    for each in state.findall('model'):
        name = name_of(each)
        if name in within:
            inside = '{}{}::'.format(prefix, name)
            starts.update({inside + name_of(link): pose_of(each) @ pose_of(link)
                           for link in within[name].findall('link')})
            starts.update(_started(within[name], each, inside))
    return starts


def _resize(geometry: ElementTree.Element, scale: np.ndarray) -> None:
    """Multiply the sizes of the shapes that Gazebo scales."""
    for path, factor in (('box/size', scale), ('sphere/radius', scale.max()),
                         ('cylinder/radius', scale[:2].max()), ('cylinder/length', scale[2])):
        element = geometry.find(path)
        if element is not None:
            element.text = words(factor * np.ravel(value(geometry, path)))


def started(tree: Tree, starts: Starts, model: Transform) -> Tree:
    """Return a tree with its links where a state has them; model: the pose of their model."""
    parts = {part: starts[link] @ pose.inverse for link, (part, pose) in tree.model.frames.items()
             if link in starts}
    if not parts:
        return tree
    root = parts.get(tree.model.root, tree.pose)
    known = {tree.model.root: root}
    positions = {}
    for joint in tree.model.joints:     # from the root on
        parent = known[joint.parent]
        known[joint.child] = parts.get(joint.child, parent @ joint.pose)
        positions[joint.name] = _position(joint, parent.inverse @ known[joint.child])
    return tree._replace(pose=root, in_model=model.inverse @ root, positions=positions)


def _position(joint: Joint, start: Transform) -> float:
    """Return where a joint with an axis is, in rad or m; start: of the child in the parent."""
    if joint.axis is None:
        return 0.0
    moved = joint.pose.inverse @ start
    if joint.kind == PRISMATIC:
        return float(moved.translation @ joint.axis)
    turn = moved.rotation
    sine = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return float(np.arctan2(sine @ joint.axis, np.trace(turn) - 1))
