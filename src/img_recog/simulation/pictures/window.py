"""A window that shows the simulation."""
import math
import os
import time
from multiprocessing.connection import Connection
from typing import Optional, Sequence

import pybullet

from img_recog.model import SUN
from img_recog.processes.helper_process import HelperProcess
from img_recog.simulation.physics.body import BodyPose
from img_recog.simulation.physics.client import client_argument, connect
from img_recog.simulation.pictures.scene import Scene, SceneCopy
from img_recog.simulation.pictures.view import ABOVE, FIELD_OF_VIEW, Viewpoint

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
            '--background_color_blue=0.7 --width=1024 --height=768')


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
