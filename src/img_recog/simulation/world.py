"""The physics client and what is in it beside robots."""
from typing import List

import pybullet

from img_recog.simulation.body import Body
from img_recog.simulation.loading import load_sdf, load_urdf
from img_recog.simulation.settings import PhysicsSettings, SimulationError
from img_recog.simulation.world_file import WorldFile

GRAVITY = 9.8                   # m/s2, Gazebo's default
_FLOOR_HALF_SIZE = 20.0         # m, of the visible floor; the plane that carries has no end
_FLOOR_COLOUR = (0.72, 0.72, 0.72, 1.0)
_FRICTION = 1.0                 # PyBullet multiplies it with the robot's coefficient


class World:
    """A PyBullet client with gravity, a floor at z 0 and the bodies of a world file.

    client: the physicsClientId, to be passed to every PyBullet call; step_s: of the physics;
    floor, bodies: the floor, and what the world file brought.
    """

    def __init__(self, settings: PhysicsSettings, file: WorldFile, client: int):
        """Build the world; raise SimulationError when that cannot be done."""
        self.client, self.step_s = client, settings.step_s
        pybullet.setTimeStep(settings.step_s, physicsClientId=client)
        pybullet.setGravity(0, 0, -GRAVITY, physicsClientId=client)
        # contacts in a fixed order, so that equal commands give equal trajectories
        pybullet.setPhysicsEngineParameter(deterministicOverlappingPairs=1,
                                           physicsClientId=client)
        self.floor = Body(add_floor(client), client, fixed=True)
        self.floor.name = 'ground_plane'        # as Gazebo calls it
        self.bodies = load_bodies(file, client)
        for body in [self.floor] + self.bodies:
            for link in body.links:
                pybullet.changeDynamics(body.number, link, lateralFriction=_FRICTION,
                                        physicsClientId=client)

    def step(self, count: int = 1) -> None:
        """Advance the physics by a number of steps."""
        step, client = pybullet.stepSimulation, self.client
        for _ in range(count):
            step(physicsClientId=client)

    def reset(self) -> None:
        """Put everything back to where it was at first, at rest."""
        for body in self.bodies:
            body.reset()


def add_floor(client: int, visible: bool = False) -> int:
    """Add the floor, an endless plane of which a square may be seen; return its body."""
    plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=client)
    slab = -1
    if visible:
        slab = pybullet.createVisualShape(
            pybullet.GEOM_BOX, halfExtents=(_FLOOR_HALF_SIZE, _FLOOR_HALF_SIZE, 0.005),
            visualFramePosition=(0, 0, -0.005), rgbaColor=_FLOOR_COLOUR,
            specularColor=(0, 0, 0), physicsClientId=client)
    return pybullet.createMultiBody(0, plane, slab, physicsClientId=client)


def load_bodies(file: WorldFile, client: int) -> List[Body]:
    """Load what a world file describes; SimulationError when PyBullet cannot."""
    what = 'world {}'.format(file.name)
    if not file.text:
        return []
    if not file.sdf:
        body = Body(load_urdf(file.text, client, fixed=True, what=what), client, fixed=True)
        body.name = file.name
        return [body]
    bodies = [Body(number, client) for number in load_sdf(file.text, client, what)]
    if not bodies:
        raise SimulationError('{}: PyBullet finds no model in it; set world to the file of a '
                              'model, whatever <include> leads to it'.format(what))
    return bodies
