"""The physics client, and everything in it except robots."""
from typing import List

import pybullet

from img_recog.simulation.body import Body
from img_recog.simulation.loading import load_urdf
from img_recog.simulation.settings import PhysicsSettings, SimulationError
from img_recog.simulation.world_file import WorldFile

_FLOOR_HALF_SIZE_M = 20.0       # of the visible floor; the plane that carries is infinite
_FLOOR_COLOR = (0.72, 0.72, 0.72, 1.0)
_FRICTION = 1.0                 # PyBullet multiplies it with the robot's coefficient


class World:
    """A physics client with gravity, a floor at z 0 and the bodies of a world file.

    physics_client_id: to be passed to every PyBullet call; step_s: of the physics; floor; bodies:
    those of the world file.
    """

    def __init__(self, settings: PhysicsSettings, file: WorldFile, physics_client_id: int):
        """Build the world in a physics client; SimulationError when PyBullet cannot load it."""
        self.physics_client_id, self.step_s = physics_client_id, settings.step_s
        pybullet.setTimeStep(settings.step_s, physicsClientId=physics_client_id)
        pybullet.setGravity(*file.gravity, physicsClientId=physics_client_id)
        # contacts in a fixed order, so that equal commands give equal trajectories
        pybullet.setPhysicsEngineParameter(deterministicOverlappingPairs=1,
                                           physicsClientId=physics_client_id)
        self.floor = Body(add_floor(physics_client_id), physics_client_id, fixed=True)
        self.floor.name = 'ground_plane'        # Gazebo's name for it
        self.bodies = load_bodies(file, physics_client_id)
        for body in [self.floor] + self.bodies:
            for link in body.links:
                pybullet.changeDynamics(body.body_id, link, lateralFriction=_FRICTION,
                                        physicsClientId=physics_client_id)

    def step(self, count: int = 1) -> None:
        """Advance the physics by a number of steps."""
        # local names: this is the innermost loop
        step, physics_client_id = pybullet.stepSimulation, self.physics_client_id
        for _ in range(count):
            step(physicsClientId=physics_client_id)

    def reset(self) -> None:
        """Move all bodies back to where they were at the start, at rest."""
        for body in self.bodies:
            body.reset()


def add_floor(physics_client_id: int, visible: bool = False) -> int:
    """Add the floor, an infinite plane of which a square may be visible; return its body's id."""
    plane = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=physics_client_id)
    slab = -1
    if visible:
        slab = pybullet.createVisualShape(
            pybullet.GEOM_BOX, halfExtents=(_FLOOR_HALF_SIZE_M, _FLOOR_HALF_SIZE_M, 0.005),
            visualFramePosition=(0, 0, -0.005), rgbaColor=_FLOOR_COLOR,
            specularColor=(0, 0, 0), physicsClientId=physics_client_id)
    return pybullet.createMultiBody(0, plane, slab, physicsClientId=physics_client_id)


def load_bodies(file: WorldFile, physics_client_id: int) -> List[Body]:
    """Load what a world file describes; SimulationError when PyBullet cannot."""
    bodies = []
    for tree in file.trees:
        try:
            body = Body(load_urdf(tree.urdf, physics_client_id, tree.fixed, tree.pose),
                        physics_client_id, tree.fixed)
        except SimulationError as error:
            raise SimulationError('world {}: model {}: {}'.format(
                file.name, tree.name, error.problem), error.advice)
        body.name = tree.name
        bodies.append(body)
    return bodies
