"""Images of the simulation for people, drawn without a display."""
import math
import threading
import time
from typing import NamedTuple, Optional, Sequence

import numpy as np

from img_recog.simulation.body import Pose, rotation_matrix
from img_recog.simulation.geometry import to_rpy
from img_recog.simulation.loading import connect
from img_recog.simulation.rendering import Camera, render
from img_recog.simulation.scene import Helper, Scene, SceneCopy
from img_recog.simulation.settings import SimulationError, ViewSettings

# as Gazebo's user camera of turtlebot3_world: straight down from (0.8, 0, 12) with x upwards
ABOVE = Camera(target=(0.8, 0.0, 0.0), distance=12.0, yaw=-90.0, pitch=-89.99)
_FOLLOW_DISTANCE = 1.3          # m, and degrees: over the walls of turtlebot3_world
_FOLLOW_PITCH = -68.0


class ViewImage(NamedTuple):
    """An image, uint8 RGB of shape (height, width, 3), and the simulated time in s it shows."""

    pixels: np.ndarray
    time_s: float


class View:
    """Asks a process of its own for images, one at a time and no more often than wanted.

    `request` belongs to the simulation, `next_image` to whoever takes the images.
    """

    def __init__(self, scene: Scene, settings: ViewSettings):
        self._scene, self._settings = scene, settings
        self._helper: Optional[Helper] = None
        self._busy = False
        self._next_s = 0.0
        self._started = threading.Event()

    def due(self) -> bool:
        """Return whether an image may be asked for: the last has come and its time is over."""
        return not self._busy and time.monotonic() >= self._next_s

    def request(self, poses: Sequence[Pose], time_s: float) -> None:
        """Ask for an image of these poses; the first is what a following camera follows."""
        if self._helper is None:
            self._helper = Helper(_draw, (self._scene, self._settings))
            self._started.set()
        self._next_s = time.monotonic() + 1 / self._settings.view_rate
        self._busy = True
        try:
            self._helper.connection.send((poses, time_s))
        except OSError:
            pass                    # that process has ended, as next_image will tell

    def next_image(self, timeout_s: float) -> Optional[ViewImage]:
        """Return the image that was asked for if it comes in time, else None.

        Raises SimulationError when the process that draws has ended.
        """
        if not self._started.wait(timeout_s):
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
    """Return a camera behind and above a body, looking the way that it does."""
    heading = math.degrees(to_rpy(rotation_matrix(pose.orientation))[2])
    # PyBullet's camera at yaw 0 looks along y
    return Camera(tuple(pose.position), _FOLLOW_DISTANCE, heading - 90.0, _FOLLOW_PITCH)


def _draw(connection, scene: Scene, settings: ViewSettings) -> None:
    client = connect()
    copy = SceneCopy(scene, client, floor=False)
    try:
        while True:
            poses, time_s = connection.recv()
            copy.place(poses)
            camera = follow(poses[0]) if settings.view == 'follow' else ABOVE
            connection.send(ViewImage(
                render(client, camera, settings.view_width, settings.view_height), time_s))
    except (EOFError, OSError):
        pass
