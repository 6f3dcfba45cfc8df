"""What touches a body now."""
from typing import List, NamedTuple

import pybullet

from img_recog.simulation.physics.body import Body


class ContactPoint(NamedTuple):
    """A point at which a body touches another one or itself.

    link: PyBullet's number of the link of the body; other: PyBullet's id of the other body;
    depth_m: how deep they are in one another, below 0 for a gap; up: the vertical part of the
    normal, from -1 to 1; force: along the normal, in N.
    """

    link: int
    other: int
    depth_m: float
    up: float
    force: float


def of(body: Body, detect: bool = False) -> List[ContactPoint]:
    """Return the contacts of a body in the last step of the physics.

    detect: look for those of where the bodies are now instead.
    """
    if detect:
        pybullet.performCollisionDetection(**body.client)
    # of two robots, either may be the first body of a contact
    return [ContactPoint(*((point[4], point[1]) if point[2] == body.body_id
                           else (point[3], point[2])), -point[8], point[7][2], point[9])
            for point in pybullet.getContactPoints(body.body_id, **body.client)]
