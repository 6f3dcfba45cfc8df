"""Gearboxes and screws of an SDF: what holds two of a tree's joints together."""
from typing import Iterable, List, Mapping, Optional, Sequence

import numpy as np

from img_recog.formats.sdf_joints import SdfJoint
from img_recog.model import PRISMATIC, Gear, Joint
from img_recog.report import NOT_SIMULATED, Report

_PARALLEL = 0.999       # the cosine of an angle


def of_screw(joint: SdfJoint, parts: Sequence[Joint]) -> Gear:
    """Return the gear of a screw, of which the parts turn and slide: as in Gazebo, it slides by
    the angle divided by the negative pitch."""
    slides, = (part.name for part in parts if part.kind == PRISMATIC)
    turns, = (part.name for part in parts if part.kind != PRISMATIC)
    return Gear(turns, slides, joint.ratio)


def of_boxes(boxes: Iterable[SdfJoint], joints: Mapping[str, SdfJoint], root: Optional[str],
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
