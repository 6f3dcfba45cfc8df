"""A window that shows the simulation."""
import math
import select
import time
from multiprocessing.connection import Connection
from typing import Optional, Sequence

import pybullet

from img_recog.simulation.body import Pose
from img_recog.simulation.loading import connect
from img_recog.simulation.rendering import FIELD_OF_VIEW, WINDOW_LIGHT
from img_recog.simulation.scene import Helper, Scene, SceneCopy
from img_recog.simulation.view import ABOVE

_PERIOD_S = 1 / 30
# The window's vertical field of view is 90 degrees: its camera must be nearer than the view's to
# show the same part of the floor. 1.25: from nearer, tall bodies look larger than in the view.
_DISTANCE_FACTOR = (1.25 * math.tan(math.radians(FIELD_OF_VIEW / 2))
                    / math.tan(math.radians(45)))
_OPTIONS = ('--background_color_red=0.7 --background_color_green=0.7 '
            '--background_color_blue=0.7 --width=1024 --height=768')


class Window:
    """The sending end of a window, which a separate process shows."""

    def __init__(self, scene: Scene):
        """Open the window."""
        self._helper = Helper(_show, (scene,))
        self._next_s = 0.0

    def due(self) -> bool:
        """Return whether it is time to send new poses."""
        return time.monotonic() >= self._next_s

    def show(self, poses: Sequence[Pose]) -> Optional[str]:
        """Send the poses; return the reason when the window is gone, else None."""
        self._next_s = time.monotonic() + _PERIOD_S
        connection = self._helper.connection
        try:
            # a window that opens slowly or stalls must not block the simulation
            poller = select.poll()
            poller.register(connection, select.POLLOUT)
            if poller.poll(0):
                connection.send(poses)
        except OSError:
            return 'closed' if self._helper.end() else 'it could not be opened or broke'
        return None

    def close(self) -> None:
        """Close the window."""
        self._helper.end()


def _show(connection: Connection, scene: Scene) -> None:
    """Show the newest poses until the window or the other end of the connection is closed."""
    physics_client_id = connect(pybullet.GUI, _OPTIONS)
    pybullet.configureDebugVisualizer(pybullet.COV_ENABLE_GUI, 0,
                                      physicsClientId=physics_client_id)
    pybullet.configureDebugVisualizer(physicsClientId=physics_client_id, **WINDOW_LIGHT)
    copy = SceneCopy(scene, physics_client_id, floor=True)
    pybullet.resetDebugVisualizerCamera(
        cameraDistance=ABOVE.distance * _DISTANCE_FACTOR, cameraYaw=ABOVE.yaw,
        cameraPitch=ABOVE.pitch, cameraTargetPosition=ABOVE.target,
        physicsClientId=physics_client_id)
    try:
        while pybullet.isConnected(physicsClientId=physics_client_id):
            poses = connection.recv()
            while connection.poll():
                poses = connection.recv()
            copy.place(poses)
    except (EOFError, pybullet.error):
        pass
