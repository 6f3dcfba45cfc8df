"""Gears between joints of a body: PyBullet's constraints of that kind."""
from typing import List

import pybullet

from img_recog.simulation.physics.framed_body import FramedBody

_MAX_FORCE = 1e9        # N or N m: more than a gear ever takes
_ERP = 0.2              # of what a hard limit left of an error of the positions, in each step


def add(body: FramedBody) -> List[int]:
    """Let the gears of a body's model hold; return the ids of their constraints.

    They must be removed before the body.
    """
    ids = []
    for gear in body.model.gears:
        ids.append(pybullet.createConstraint(
            body.body_id, body.joints[gear.joint], body.body_id, body.joints[gear.other],
            pybullet.JOINT_GEAR, [0, 0, 1], [0, 0, 0], [0, 0, 0], **body.client))
        pybullet.changeConstraint(ids[-1], gearRatio=gear.ratio, maxForce=_MAX_FORCE, erp=_ERP,
                                  **body.client)
    return ids
