"""Loads the text of a URDF or SDF into a physics client."""
import contextlib
import os
from typing import Iterator, Tuple

import pybullet

from img_recog.simulation.settings import SimulationError

# exact cylinders: the default, a convex hull, is 1 mm larger and rolls on facets
_URDF_FLAGS = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER


def connect(mode: int = pybullet.DIRECT, options: str = '') -> int:
    """Return the id of a new physics client, by default one without a window."""
    # with an empty options argument, PyBullet prints it
    physics_client_id = pybullet.connect(mode, **({'options': options} if options else {}))
    if physics_client_id < 0:
        raise SimulationError('PyBullet cannot start a physics client',
                              'check whether too many are in use')
    # its cache goes by file name, and `_file` gives each text the same one
    pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=physics_client_id)
    return physics_client_id


def load_urdf(urdf: str, physics_client_id: int, fixed: bool = False) -> int:
    """Load the text of a URDF, in which all meshes have absolute paths; return its body's id.

    fixed: whether the root link never moves.
    Raises SimulationError when PyBullet cannot load it.
    """
    with _file(urdf) as path, _refusal('URDF'):
        return pybullet.loadURDF(path, useFixedBase=fixed, flags=_URDF_FLAGS,
                                 physicsClientId=physics_client_id)


def load_sdf(sdf: str, physics_client_id: int) -> Tuple[int, ...]:
    """Load the text of an SDF, in which all meshes have absolute paths; return its bodies' ids.

    Raises SimulationError when PyBullet cannot load it.
    """
    with _file(sdf) as path, _refusal('SDF'):
        return pybullet.loadSDF(path, physicsClientId=physics_client_id)


@contextlib.contextmanager
def _refusal(kind: str) -> Iterator[None]:
    try:
        yield
    except pybullet.error as error:
        raise SimulationError('PyBullet cannot load it as {} ({})'.format(kind, error),
                              "see PyBullet's own lines above for the reason")


@contextlib.contextmanager
def _file(text: str) -> Iterator[str]:
    """Give the path of a file in memory that holds `text`."""
    descriptor = os.memfd_create('description')
    try:
        with os.fdopen(descriptor, 'w', closefd=False) as file:
            file.write(text)
        yield '/proc/self/fd/{}'.format(descriptor)
    finally:
        os.close(descriptor)
