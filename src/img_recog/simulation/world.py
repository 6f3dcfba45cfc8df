"""The physics client and what stands still in it."""
import os
from typing import Dict

import pybullet

from img_recog.simulation.settings import PhysicsSettings, SimulationError

GRAVITY = 9.8                   # m/s2, Gazebo's default
_FLOOR_HALF_SIZE = 20.0         # m, of the visible floor; the plane that carries has no end
_FLOOR_COLOUR = (0.72, 0.72, 0.72, 1.0)
_FRICTION = 1.0                 # PyBullet multiplies it with the robot's coefficient


class World:
    """A PyBullet client with gravity, a floor at z 0 and a world file.

    client: the physicsClientId, to be passed to every PyBullet call. The client is taken from
    the caller so that the same world can be built for the physics and for a window.
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
        self._add_floor()
        if settings.world != 'empty':
            self._load(settings.world, worlds)

    def step(self) -> None:
        """Advance the physics by one step."""
        pybullet.stepSimulation(physicsClientId=self.client)

    def _add_floor(self) -> None:
        plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self.client)
        slab = pybullet.createVisualShape(
            pybullet.GEOM_BOX, halfExtents=(_FLOOR_HALF_SIZE, _FLOOR_HALF_SIZE, 0.005),
            visualFramePosition=(0, 0, -0.005), rgbaColor=_FLOOR_COLOUR,
            specularColor=(0, 0, 0), physicsClientId=self.client)
        body = pybullet.createMultiBody(0, plane, slab, physicsClientId=self.client)
        self._set_friction(body)

    def _load(self, name: str, worlds: Dict[str, str]) -> None:
        path = worlds.get(name, name)
        if not os.path.isfile(path):
            raise SimulationError('world: got {!r}, which is no file; allowed is {}, empty or the '
                                  'path of a URDF file'.format(name, ', '.join(sorted(worlds))))
        try:
            # cylinders proper: as the default convex hulls they would be up to 1 mm larger
            body = pybullet.loadURDF(path, useFixedBase=True, physicsClientId=self.client,
                                     flags=pybullet.URDF_USE_IMPLICIT_CYLINDER)
        except pybullet.error as error:
            raise SimulationError('world: cannot load {} as URDF: {}'.format(path, error))
        self._set_friction(body)

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
