"""The physics client and what stands still in it."""
import os
import tempfile
from typing import Dict

import pybullet

from img_recog.simulation.settings import PhysicsSettings, SimulationError

GRAVITY = 9.8                   # m/s2, Gazebo's default
_FLOOR_HALF_SIZE = 20.0         # m, of the visible floor; the plane that carries has no end
_FLOOR_COLOUR = (0.72, 0.72, 0.72, 1.0)
# cylinders proper: as the default convex hulls they are 1 mm larger and roll on facets
_LOAD_FLAGS = pybullet.URDF_USE_INERTIA_FROM_FILE | pybullet.URDF_USE_IMPLICIT_CYLINDER
_FRICTION = 1.0                 # PyBullet multiplies it with the robot's coefficient


class World:
    """A PyBullet client with gravity, a floor at z 0 and a world file.

    client: the physicsClientId, to be passed to every PyBullet call.
    """

    def __init__(self, settings: PhysicsSettings, worlds: Dict[str, str], client: int):
        """Build the world.

        worlds: from the names that `settings.world` may have besides a path, and `empty`, to
        paths of URDF files. Raises SimulationError when the world cannot be loaded.
        """
        self.client = client
        pybullet.setTimeStep(settings.step_s, physicsClientId=client)
        pybullet.setGravity(0, 0, -GRAVITY, physicsClientId=client)
        # contacts in a fixed order, so that equal commands give equal trajectories
        pybullet.setPhysicsEngineParameter(deterministicOverlappingPairs=1,
                                           physicsClientId=client)
        bodies = [add_floor(client)]
        if settings.world != 'empty':
            bodies.append(load_urdf(read_world(settings.world, worlds), client, fixed=True))
        for body in bodies:
            self._set_friction(body)

    def step(self) -> None:
        """Advance the physics by one step."""
        pybullet.stepSimulation(physicsClientId=self.client)

    def _set_friction(self, body: int) -> None:
        for link in range(-1, pybullet.getNumJoints(body, physicsClientId=self.client)):
            pybullet.changeDynamics(body, link, lateralFriction=_FRICTION,
                                    physicsClientId=self.client)


def connect() -> int:
    """Return a new physics client without a window."""
    client = pybullet.connect(pybullet.DIRECT)
    if client < 0:
        raise SimulationError('PyBullet gives no physics client; are too many in use?')
    return client


def add_floor(client: int) -> int:
    """Add the floor, an endless plane of which a square is seen; return its body."""
    plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    slab = pybullet.createVisualShape(
        pybullet.GEOM_BOX, halfExtents=(_FLOOR_HALF_SIZE, _FLOOR_HALF_SIZE, 0.005),
        visualFramePosition=(0, 0, -0.005), rgbaColor=_FLOOR_COLOUR, specularColor=(0, 0, 0),
        physicsClientId=client)
    return pybullet.createMultiBody(0, plane, slab, physicsClientId=client)


def read_world(name: str, worlds: Dict[str, str]) -> str:
    """Return the URDF of a world other than `empty`; arguments and errors are World's."""
    path = worlds.get(name, os.path.expanduser(name))
    try:
        with open(path) as file:
            return file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise SimulationError('world: got {!r}, which cannot be read as a file ({}); allowed is '
                              '{}, empty or the path of a URDF file'
                              .format(name, error, ', '.join(sorted(worlds))))


def load_urdf(urdf: str, client: int, fixed: bool = False) -> int:
    """Load the text of a URDF and return its body.

    fixed: whether it is part of the world and never moves.
    Raises SimulationError when PyBullet cannot load it.
    """
    handle, path = tempfile.mkstemp(suffix='.urdf')
    try:
        with os.fdopen(handle, 'w') as file:
            file.write(urdf)
        return pybullet.loadURDF(path, useFixedBase=fixed, flags=_LOAD_FLAGS,
                                 physicsClientId=client)
    except pybullet.error as error:
        raise SimulationError('{}: PyBullet cannot load it as URDF ({}); its own lines above may '
                              'say why'.format('world' if fixed else 'robot_description', error))
    finally:
        os.unlink(path)
