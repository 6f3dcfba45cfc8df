"""A copy of the simulation that is drawn by a separate process.

Drawing takes far longer than a step of the physics, and PyBullet ends the process when its window
is closed or no display can be opened. Therefore a copy is drawn, to which the simulation sends
poses; whether it exists does not influence the simulation.
"""
from typing import List, NamedTuple, Sequence

import pybullet

from img_recog.formats.world_file import WorldFile
from img_recog.model import Tree
from img_recog.simulation.physics.body import Body, BodyPose
from img_recog.simulation.physics.client import client_argument
from img_recog.simulation.physics.world import load_bodies
from img_recog.simulation.pictures.link_colors import split_links_by_color
from img_recog.simulation.simulator import Simulator

_FLOOR_HALF_SIZE_M = 20.0
_FLOOR_COLOR = (0.72, 0.72, 0.72, 1.0)


class Scene(NamedTuple):
    """What a copy is built from; it can be sent to another process.

    Attributes:
        trees: Trees of links of all models but the floor.
        world: What the world file says besides its models.
    """

    trees: Sequence[Tree]
    world: WorldFile


class SceneCopy:
    """The bodies of a scene in a physics client that never steps, in the order of `poses_of`."""

    def __init__(self, scene: Scene, physics_client_id: int, floor: bool):
        """Load the scene; floor: whether to add a visible floor."""
        self._physics_client_id = physics_client_id
        self.bodies: List[Body] = []
        self.load(scene)
        if floor:
            _add_floor(physics_client_id)

    def load(self, scene: Scene) -> None:
        """Replace the bodies by those of a scene.

        A window draws nothing until `place`. Otherwise, PyBullet draws it between any two shapes:
        on a busy processor without a GPU, this takes a minute, in which the robot is not seen.
        """
        self._is_hidden = True
        client = client_argument(self._physics_client_id)
        pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_RENDERING, 0, **client)
        for body in self.bodies:
            pybullet.removeBody(body.body_id, **client)
        trees = [tree._replace(model=split_links_by_color(tree.model)) for tree in scene.trees]
        self.bodies = [body for _, body in load_bodies(trees, self._physics_client_id,
                                                       visuals=True)]
        for body in self.bodies:
            for link in body.links:
                # otherwise each tall body would show a reflection of the sun
                pybullet.changeVisualShape(body.body_id, link, specularColor=(0, 0, 0), **client)

    def place(self, poses: Sequence[BodyPose]) -> None:
        """Move the bodies to the poses that `poses_of` returns for the simulation."""
        for body, pose in zip(self.bodies, poses):
            body.place(pose)
        if self._is_hidden:
            pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_RENDERING, 1,
                                              physicsClientId=self._physics_client_id)
            self._is_hidden = False


def _add_floor(physics_client_id: int) -> None:
    slab = pybullet.createVisualShape(
        pybullet.GEOM_BOX, halfExtents=(_FLOOR_HALF_SIZE_M, _FLOOR_HALF_SIZE_M, 0.005),
        visualFramePosition=(0, 0, -0.005), rgbaColor=_FLOOR_COLOR,
        specularColor=(0, 0, 0), physicsClientId=physics_client_id)
    pybullet.createMultiBody(0, -1, slab, physicsClientId=physics_client_id)


def scene_of(simulator: Simulator) -> Scene:
    """Return what there is to draw of a simulator now."""
    return Scene(simulator.world.trees, simulator.world.file)


def poses_of(simulator: Simulator) -> Sequence[BodyPose]:
    """Return the poses of all bodies in the order of a SceneCopy."""
    return [body.pose() for body in simulator.world.bodies]
