"""Images of the simulation, drawn without a display."""
import math
import threading
import time
from multiprocessing.connection import Connection
from typing import NamedTuple, Optional, Sequence

import numpy as np

from img_recog.simulation.body import Pose, rotation_matrix
from img_recog.simulation.geometry import to_rpy
from img_recog.simulation.loading import connect
from img_recog.simulation.rendering import Camera, render
from img_recog.simulation.scene import Helper, Scene, SceneCopy
from img_recog.simulation.settings import SimulationError, ViewSettings

# like Gazebo's user camera of turtlebot3_world: straight down from (0.8, 0, 12), x upwards
ABOVE = Camera(target=(0.8, 0.0, 0.0), distance=12.0, yaw=-90.0, pitch=-89.99)
_FOLLOW_DISTANCE_M = 1.3        # distance and pitch look over the walls of turtlebot3_world
_FOLLOW_PITCH_DEG = -68.0


class ViewImage(NamedTuple):
    """An image, uint8 RGB of shape (height, width, 3), and its simulated time in s."""

    pixels: np.ndarray
    time_s: float


class View:
    """Requests images from a separate process, one at a time and no more often than `view_rate`.

    `request` is for the thread of the simulation, `next_image` for the one that takes the images.
    """

    def __init__(self, scene: Scene, settings: ViewSettings):
        self._scene, self._settings = scene, settings
        self._helper: Optional[Helper] = None
        self._busy = False
        self._next_s = 0.0
        self._started = threading.Event()

    def due(self) -> bool:
        """Return whether to request an image: the last one has come, and its period is over."""
        return not self._busy and time.monotonic() >= self._next_s

    def request(self, poses: Sequence[Pose], time_s: float) -> None:
        """Request an image of these poses; a following camera follows the first."""
        if self._helper is None:
            self._helper = Helper(_draw, (self._scene, self._settings))
            self._started.set()
        self._next_s = time.monotonic() + 1 / self._settings.view_rate
        self._busy = True
        try:
            self._helper.connection.send((poses, time_s))
        except OSError:
            pass                    # the process has ended; next_image raises the error

    def next_image(self, timeout_s: float) -> Optional[ViewImage]:
        """Return the requested image if it comes in time, else None.

        Raises SimulationError when the process that draws has ended.
        """
        if not self._started.wait(timeout_s) or self._helper is None:
            return None
        try:
            if not self._helper.connection.poll(timeout_s):
                return None
            image = self._helper.connection.recv()
        except (EOFError, OSError):
            raise SimulationError('the process that draws the view has ended')
        self._busy = False
        return image

    def close(self) -> None:
        """End the process."""
        if self._helper is not None:
            self._helper.end()


def follow(pose: Pose) -> Camera:
    """Return a camera behind and above a body that looks in the body's direction."""
    heading = math.degrees(to_rpy(rotation_matrix(pose.orientation))[2])
    x, y, z = pose.position
    # at yaw 0, PyBullet's camera looks along y
    return Camera((x, y, z), _FOLLOW_DISTANCE_M, heading - 90.0, _FOLLOW_PITCH_DEG)


def _draw(connection: Connection, scene: Scene, settings: ViewSettings) -> None:
    """Draw images on request until the other end of the connection is closed."""
    physics_client_id = connect()
    copy = SceneCopy(scene, physics_client_id, floor=False)
    try:
        while True:
            poses, time_s = connection.recv()
            copy.place(poses)
            camera = follow(poses[0]) if settings.view == 'follow' else ABOVE
            pixels = render(physics_client_id, camera, settings.view_width, settings.view_height)
            connection.send(ViewImage(pixels, time_s))
    except (EOFError, OSError):
        pass
