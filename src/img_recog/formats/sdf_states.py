"""The <state> of an SDF world: where its models and links are at the start."""
import xml.etree.ElementTree as ElementTree
from typing import Dict, Mapping, Optional

import numpy as np

from img_recog.formats.sdf_frames import pose_of, set_pose
from img_recog.model import PRISMATIC, Joint, Tree
from img_recog.rotations import Transform

Starts = Mapping[str, Transform]


def apply(model: ElementTree.Element, state: Optional[ElementTree.Element]) -> Starts:
    """Move a model to where the <state> of its world has it, as in Gazebo.

    Returns the poses of its links in the world that the state gives, by name.
    """
    starts: Dict[str, Transform] = {}
    for each in () if state is None else state.findall('model'):
        if each.get('name') == model.get('name'):
            set_pose(model, pose_of(each))
            starts = {link.get('name', ''): pose_of(link) for link in each.findall('link')
                      if link.find('pose') is not None}
    return starts


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
    axis = joint.axis / np.linalg.norm(joint.axis)
    if joint.kind == PRISMATIC:
        return float(moved.translation @ axis)
    turn = moved.rotation
    sine = np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
    return float(np.arctan2(sine @ axis, np.trace(turn) - 1))
