"""Text of URDF and SDF into a physics client."""
import contextlib
import os
from typing import Iterator, Tuple

import pybullet

from img_recog.simulation.settings import SimulationError

# cylinders proper: as the default convex hulls they are 1 mm larger and roll on facets
_URDF_FLAGS = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER


def connect(mode: int = pybullet.DIRECT, options: str = '') -> int:
    """Return a new physics client, by default one without a window."""
    # given no options at all, it says nothing about them
    client = pybullet.connect(mode, **({'options': options} if options else {}))
    if client < 0:
        raise SimulationError('PyBullet gives no physics client; are too many in use?')
    # it knows files by their names, and the text below has the same name each time
    pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)
    return client


def load_urdf(urdf: str, client: int, fixed: bool = False, what: str = 'robot_description') -> int:
    """Load the text of a URDF, all meshes in it by absolute paths, and return its body.

    fixed: whether its root link never moves. what: it is, for the error.
    Raises SimulationError when PyBullet cannot load it.
    """
    with _file(urdf) as path, _refusal(what, 'URDF'):
        return pybullet.loadURDF(path, useFixedBase=fixed, flags=_URDF_FLAGS,
                                 physicsClientId=client)


def load_sdf(sdf: str, client: int, what: str) -> Tuple[int, ...]:
    """Load the text of an SDF, all meshes in it by absolute paths, and return its bodies.

    what: it is, for the error. Raises SimulationError when PyBullet cannot load it.
    """
    with _file(sdf) as path, _refusal(what, 'SDF'):
        return pybullet.loadSDF(path, physicsClientId=client)


@contextlib.contextmanager
def _refusal(what: str, kind: str) -> Iterator[None]:
    try:
        yield
    except pybullet.error as error:
        raise SimulationError('{}: PyBullet cannot load it as {} ({}); its own lines above may '
                              'say why'.format(what, kind, error))


@contextlib.contextmanager
def _file(text: str) -> Iterator[str]:
    """Give the path of a file that holds `text` and is nowhere on a disk."""
    handle = os.memfd_create('description')
    try:
        with os.fdopen(handle, 'w', closefd=False) as file:
            file.write(text)
        yield '/proc/self/fd/{}'.format(handle)
    finally:
        os.close(handle)
