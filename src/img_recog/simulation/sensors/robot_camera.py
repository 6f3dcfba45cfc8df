"""A camera on a robot: what is to be drawn, and when."""
import math
from typing import Callable, NamedTuple

import numpy as np

from img_recog import rotations
from img_recog.formats.gazebo_tags import Tags
from img_recog.rotations import Transform, transform
from img_recog.simulation.physics.framed_body import FramedBody
from img_recog.simulation.sensors.sensor import Mount, Sensor
from img_recog.simulation.simulation_settings import CameraSettings

CAMERA = 'camera'       # the name of the row
TAGS = Tags((), ())     # formats/camera_values.py reads them
_MAX_TURN = 0.01        # rad; official robots have 1.57 in place of pi / 2


class Exposure(NamedTuple):
    """All that an image shows.

    camera_pose (4, 4): of the camera in the world, as a homogeneous transform; it looks along its
    x axis. poses (n, 7): of all parts of the scene.
    """

    camera_pose: np.ndarray
    poses: np.ndarray


class RobotCamera(Sensor):
    """Reads where the camera and all else is; images are drawn elsewhere.

    settings: what it was made with. poses: returns the poses (n, 7) of all parts of the scene; who
    draws it sets that.
    """

    def __init__(self, robot: FramedBody, settings: CameraSettings,
                 poses: Callable[[], np.ndarray] = lambda: np.empty((0, 7))):
        """Mount the camera on a link of `robot`; SimulationError when there is no such link."""
        robot.check_frame('camera_frame', settings.camera_frame)
        self.settings, self.poses = settings, poses
        self._robot = robot
        self._in_link = _in_link(settings)

    def read(self) -> Exposure:
        """Return what an image of now shows."""
        motion = self._robot.motion(self.settings.camera_frame)
        pose = Transform(rotations.matrix(motion.orientation), motion.position) @ self._in_link
        return Exposure(pose.matrix(), self.poses())


def make(mount: Mount, settings: CameraSettings) -> RobotCamera:
    """Return the camera of a row of the table of sensors; errors as for RobotCamera."""
    return RobotCamera(mount.robot, settings)


def optical_frame(settings: CameraSettings) -> Transform:
    """Return the pose of the frame of the images in the link of the camera.

    x is to the right in an image, y downward, z forward (REP 103).
    """
    return _in_link(settings) @ transform((0, 0, 0), (-math.pi / 2, 0, -math.pi / 2))


def warning_about_frame(robot: FramedBody, settings: CameraSettings) -> str:
    """Return a line if a link that is the frame of the images is not turned like them, else ''."""
    link = settings.camera_optical_frame
    if not robot.has_frame(link):
        return ''
    carrier, given = (rotations.matrix(robot.motion(each).orientation)
                      for each in (settings.camera_frame, link))
    cosine = (np.trace(given.T @ carrier @ optical_frame(settings).rotation) - 1) / 2
    if cosine > math.cos(_MAX_TURN):
        return ''
    return ('the images of the camera on {} have the frame {}, a link that is not turned like an '
            'image (x to the right, y downward, z forward: REP 103); what is seen is elsewhere in '
            'tf'.format(settings.camera_frame, link))


def _in_link(settings: CameraSettings) -> Transform:
    """Return the pose of the camera in its link."""
    return transform((settings.camera_x, settings.camera_y, settings.camera_z),
                     (settings.camera_roll, settings.camera_pitch, settings.camera_yaw))
