"""A window that shows a copy of the simulation, which a separate process draws.

Drawing takes far longer than a step of the physics, and PyBullet ends the process when its window
is closed or no display can be opened. Therefore a copy is drawn, to which the simulation sends
poses; whether it exists does not influence the simulation.
"""
import dataclasses
import math
import os
import time
from multiprocessing.connection import Connection
from typing import Dict, List, NamedTuple, Optional, Sequence

import pybullet

from img_recog.formats.world_file import WorldFile
from img_recog.model import FIXED, SUN, Joint, Link, Look, Material, Model, Tree
from img_recog.processes.helper_process import HelperProcess
from img_recog.simulation.physics.body import Body, BodyPose
from img_recog.simulation.physics.client import client_argument, connect
from img_recog.simulation.physics.world import load_bodies
from img_recog.simulation.pictures.view import ABOVE, FIELD_OF_VIEW, Viewpoint
from img_recog.simulation.simulator import Simulator

_PERIOD_S = 1 / 30
_NICENESS = 10              # where OpenGL runs on the processor, the physics comes first
# Gazebo's sun, whatever the world has. Far away, so that all light has the same direction; bodies
# need specularColor (0, 0, 0), or a tall one shows a reflection of the light.
_LIGHT = {'lightPosition': tuple(-100 * axis for axis in SUN.direction), 'shadowMapWorldSize': 14,
          'shadowMapResolution': 4096}
# The window's vertical field of view is 90 degrees: its camera must be nearer than the view's to
# show the same part of the floor. 1.25: from nearer, tall bodies look larger than in the view.
_DISTANCE_FACTOR = (1.25 * math.tan(math.radians(FIELD_OF_VIEW / 2))
                    / math.tan(math.radians(45)))
_OPTIONS = ('--background_color_red=0.7 --background_color_green=0.7 '
            '--background_color_blue=0.7 --width=1024 --height=768 --nogui')
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


def scene_of(simulator: Simulator) -> Scene:
    """Return what there is to draw of a simulator now."""
    return Scene(simulator.world.trees, simulator.world.file)


def poses_of(simulator: Simulator) -> Sequence[BodyPose]:
    """Return the poses of all bodies in the order of a SceneCopy."""
    return [body.pose() for body in simulator.world.bodies]


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


def split_links_by_color(model: Model) -> Model:
    """Return the model with each color of a link moved to a massless link fixed to it.

    PyBullet's window paints all shapes of a link in one color.
    Inertias stay where they are; solids are removed, since they are not drawn.
    """
    added, joints = [], []
    for link in model.links:
        colors: Dict[Optional[Material], List[Look]] = {}
        for look in link.looks:
            colors.setdefault(look.material, []).append(look)
        for number, looks in enumerate(colors.values()):
            name = '{}_color_{}'.format(link.name, number)
            added.append(Link(name, looks=tuple(looks)))
            joints.append(Joint(name + '_joint', FIXED, link.name, name))
    bare = [link._replace(solids=(), looks=()) for link in model.links]
    return dataclasses.replace(model, links=(*bare, *added), joints=(*model.joints, *joints))


class Window:
    """The sending end of a window, which a separate process shows."""

    def __init__(self, scene: Scene, viewpoint: Viewpoint = ABOVE):
        """Open the window, which shows the scene from `viewpoint`."""
        self._helper = HelperProcess(show_until_closed, (scene, viewpoint), _NICENESS)
        self._next_s = 0.0
        self._new_scene: Optional[Scene] = None

    def due(self) -> bool:
        """Return whether it is time to send new poses."""
        return time.monotonic() >= self._next_s

    def set_scene(self, scene: Scene) -> None:
        """Show another scene: the poses of the next `show` are those of its bodies."""
        self._new_scene = scene

    def show(self, poses: Sequence[BodyPose]) -> Optional[str]:
        """Send the poses; return the reason when the window is gone, else None."""
        self._next_s = time.monotonic() + _PERIOD_S
        if self._helper.is_broken:
            return 'closed' if self._helper.end() == 0 else 'it could not be opened or broke'
        if not self._helper.is_sending:     # else it opens slowly, or hangs
            if self._new_scene is not None:
                self._helper.send(self._new_scene)
                self._new_scene = None
            self._helper.send(poses)
        return None

    def close(self) -> None:
        """Close the window."""
        self._helper.end()


def show_until_closed(connection: Connection, scene: Scene, viewpoint: Viewpoint) -> None:
    """Show the newest poses until the window or the other end of the connection is closed."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)    # PyBullet prints 40 lines about OpenGL
    physics_client_id = connect(pybullet.GUI, _OPTIONS)
    client = client_argument(physics_client_id)
    pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, **client)
    pybullet.configureDebugVisualizer(**_LIGHT, **client)
    # before anything is drawn
    pybullet.resetDebugVisualizerCamera(
        cameraDistance=viewpoint.distance * _DISTANCE_FACTOR, cameraYaw=viewpoint.yaw,
        cameraPitch=viewpoint.pitch, cameraTargetPosition=viewpoint.target, **client)
    copy = SceneCopy(scene, physics_client_id, floor=scene.world.has_floor)
    try:
        while pybullet.isConnected(**client):
            messages = [connection.recv()]
            while connection.poll():
                messages.append(connection.recv())
            scenes = [message for message in messages if isinstance(message, Scene)]
            if scenes:
                copy.load(scenes[-1])
            if not isinstance(messages[-1], Scene):
                copy.place(messages[-1])
    except (EOFError, pybullet.error):
        pass
