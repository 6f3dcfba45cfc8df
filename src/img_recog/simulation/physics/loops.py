"""Joints that close a loop of links, as constraints between the links of a body."""
from typing import Dict, List, Tuple

import numpy as np
import pybullet

from img_recog import rotations
from img_recog.formats.sdf_frames import WORLD
from img_recog.model import FIXED, Joint, Tree
from img_recog.rotations import Transform
from img_recog.simulation.physics.body import Body
from img_recog.simulation.physics.client import link_indices

_MAX_FORCE_N = 1e6
_HALF_AXIS_M = 0.1      # between the points that hold an axis, and its middle
_Frame = Tuple[List[float], List[float]]


def close(tree: Tree, body: Body) -> None:
    """Constrain the loops of a tree that was just loaded; they end with the body."""
    indices = link_indices(body.body_id, body.physics_client_id)
    for loop in tree.model.loops:
        _constrain(loop, tree.pose @ loop.pose, body, indices)


def _constrain(loop: Joint, pose: Transform, body: Body, indices: Dict[str, int]) -> None:
    """Add the constraint of a loop whose joint is at `pose` in the world."""
    points = [np.zeros(3)]
    if loop.axis is not None:
        half = _HALF_AXIS_M * loop.axis / np.linalg.norm(loop.axis)
        points = [-half, half]
    kind = pybullet.JOINT_FIXED if loop.kind == FIXED else pybullet.JOINT_POINT2POINT
    # the first body of a constraint cannot be the world
    child = indices[loop.child]
    is_to_world = loop.parent == WORLD
    for point in points:
        at = Transform(pose.rotation, pose.apply(point))
        in_child = _frame(at, body, child)
        in_parent = ((at.translation.tolist(), rotations.quaternion_of(at.rotation))
                     if is_to_world else _frame(at, body, indices[loop.parent]))
        constraint = pybullet.createConstraint(
            body.body_id, child, -1 if is_to_world else body.body_id,
            -1 if is_to_world else indices[loop.parent], kind, (0, 0, 0), in_child[0],
            in_parent[0], in_child[1], in_parent[1], physicsClientId=body.physics_client_id)
        pybullet.changeConstraint(constraint, maxForce=_MAX_FORCE_N,
                                  physicsClientId=body.physics_client_id)


def _frame(pose: Transform, body: Body, link: int) -> _Frame:
    """Return a pose in the world in the frame of a link's center of mass, PyBullet's frame."""
    client = body.physics_client_id
    if link == -1:
        center = pybullet.getBasePositionAndOrientation(body.body_id, physicsClientId=client)
    else:
        center = pybullet.getLinkState(body.body_id, link, computeForwardKinematics=True,
                                       physicsClientId=client)[:2]
    return pybullet.multiplyTransforms(*pybullet.invertTransform(*center),
                                       pose.translation.tolist(),
                                       rotations.quaternion_of(pose.rotation))
