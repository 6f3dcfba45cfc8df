"""A window on the simulation."""
import math
import select
import time
from typing import Optional, Sequence

import pybullet

from img_recog.simulation.body import Pose
from img_recog.simulation.loading import connect
from img_recog.simulation.rendering import FIELD_OF_VIEW, WINDOW_LIGHT
from img_recog.simulation.scene import Helper, Scene, SceneCopy
from img_recog.simulation.view import ABOVE

_PERIOD_S = 1 / 30
# the window's field of view is 90 degrees high: from so much nearer it shows as much of what is
# high as the view does
_NEARER = 1.25 * math.tan(math.radians(FIELD_OF_VIEW / 2)) / math.tan(math.radians(45))
_OPTIONS = ('--background_color_red=0.7 --background_color_green=0.7 '
            '--background_color_blue=0.7 --width=1024 --height=768')


class Window:
    """The sending end of a window."""

    def __init__(self, scene: Scene):
        """Open the window."""
        self._helper = Helper(_show, (scene,))
        self._next_s = 0.0

    def due(self) -> bool:
        """Return whether it is time to show something new."""
        return time.monotonic() >= self._next_s

    def show(self, poses: Sequence[Pose]) -> Optional[str]:
        """Send the poses; return why the window is gone, None while it is not."""
        self._next_s = time.monotonic() + _PERIOD_S
        connection = self._helper.connection
        try:
            # a window that is slow to open or stalls must not hold up the simulation
            if select.select([], [connection], [], 0)[1]:
                connection.send(poses)
        except OSError:
            return 'closed' if self._helper.end() else 'it could not be opened or broke'
        return None

    def close(self) -> None:
        """Close the window."""
        self._helper.end()


def _show(connection, scene: Scene) -> None:
    client = connect(pybullet.GUI, _OPTIONS)
    pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0, physicsClientId=client)
    pybullet.configureDebugVisualizer(physicsClientId=client, **WINDOW_LIGHT)
    copy = SceneCopy(scene, client, floor=True)
    pybullet.resetDebugVisualizerCamera(
        cameraDistance=ABOVE.distance * _NEARER, cameraYaw=ABOVE.yaw, cameraPitch=ABOVE.pitch,
        cameraTargetPosition=ABOVE.target, physicsClientId=client)
    try:
        while pybullet.isConnected(physicsClientId=client):
            poses = connection.recv()
            while connection.poll():
                poses = connection.recv()
            copy.place(poses)
    except (EOFError, pybullet.error):
        pass
