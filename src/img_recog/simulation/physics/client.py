"""PyBullet's physics clients, and what is in them."""
import contextlib
from typing import Dict, Iterator, Sequence, Tuple

import pybullet

from img_recog.errors import SimulationError
from img_recog.rotations import Quaternion

Pose = Tuple[Sequence[float], Quaternion]        # position in m and orientation


def connect(mode: int = pybullet.DIRECT, options: str = '') -> int:
    """Return the id of a new physics client, by default one without a window."""
    # with an empty options argument, PyBullet prints it
    physics_client_id = pybullet.connect(mode, **({'options': options} if options else {}))
    if physics_client_id < 0:
        raise SimulationError('PyBullet cannot start a physics client',
                              'check whether too many are in use')
    # its cache goes by file name, and build.py gives each text the same one
    pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=physics_client_id)
    return physics_client_id


def client_argument(physics_client_id: int) -> Dict[str, int]:
    """Return the keyword argument with which a call of PyBullet goes to a physics client."""
    return {'physicsClientId': physics_client_id}


@contextlib.contextmanager
def all_or_nothing(physics_client_id: int) -> Iterator[None]:
    """Remove the bodies that were loaded in the `with` block if it raises an error."""
    before = set(body_ids(physics_client_id))
    try:
        yield
    except Exception:
        for body_id in set(body_ids(physics_client_id)) - before:
            pybullet.removeBody(body_id, physicsClientId=physics_client_id)
        raise


def body_ids(physics_client_id: int) -> Tuple[int, ...]:
    """Return the ids of all bodies in a physics client."""
    return tuple(pybullet.getBodyUniqueId(index, physicsClientId=physics_client_id)
                 for index in range(pybullet.getNumBodies(physicsClientId=physics_client_id)))


def link_indices(body_id: int, physics_client_id: int) -> Dict[str, int]:
    """Return PyBullet's index of each link of a body by its name, -1 for the root link."""
    client = client_argument(physics_client_id)
    indices = {pybullet.getBodyInfo(body_id, **client)[0].decode(): -1}
    for index in range(pybullet.getNumJoints(body_id, **client)):
        indices[pybullet.getJointInfo(body_id, index, **client)[12].decode()] = index
    return indices


def center(body_id: int, link: int, physics_client_id: int) -> Pose:
    """Return the pose of the center of mass of a link in the world.

    Args:
        body_id: PyBullet's number of the body.
        link: Its index of the link, -1 for the base.
        physics_client_id: Its number of the physics client.
    """
    client = client_argument(physics_client_id)
    if link == -1:
        return pybullet.getBasePositionAndOrientation(body_id, **client)
    return pybullet.getLinkState(body_id, link, computeForwardKinematics=1, **client)[:2]
