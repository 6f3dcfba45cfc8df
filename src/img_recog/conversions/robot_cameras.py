"""What draws the cameras of simulated robots, and what their messages say.

Depths become sensor_msgs/Image, and sensor_msgs/PointCloud2.
"""
import sys
from typing import Any, Optional, Tuple

import cv2
import numpy as np
from sensor_msgs.msg import PointCloud2, PointField
from std_msgs.msg import Header

from img_recog.camera.calibration import Calibration
from img_recog.rendering import lens_views, renderer
from img_recog.rendering.camera import Camera
from img_recog.rendering.light import LightFilter, PixelNoise
from img_recog.rendering.server import Shot
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.sensors.robot_camera import Exposure
from img_recog.simulation.simulation_settings import CameraSettings
from img_recog.simulation.simulator import Simulator

MILLIMETERS = '16UC1'       # REP 118; the other encoding is 32FC1, in m
# as of libgazebo_ros_depth_camera: 4 bytes after z and 12 after the color are not used
POINT_BYTES = 32
_POINT = np.dtype({'names': ['xyz', 'bgr'], 'formats': ['3f4', '3u1'], 'offsets': [0, 16],
                   'itemsize': POINT_BYTES})
_FIELDS = tuple(PointField(name, offset, PointField.FLOAT32, 1)
                for name, offset in (('x', 0), ('y', 4), ('z', 8), ('rgb', 16)))


class DrawnCamera:
    """A camera of a simulated robot: its optics, its noise and its calibration.

    camera: draws what it sees. calibration: None if no model can say what its lens does.
    """

    def __init__(self, settings: CameraSettings):
        self.camera = Camera(settings.camera_width, settings.camera_height,
                             settings.camera_horizontal_fov, settings.camera_near,
                             settings.camera_far, settings.lens)
        self.calibration = _calibration(settings, self.camera)
        noise = settings.camera_noise, settings.camera_noise_mean
        self._noise = PixelNoise(*noise) if any(noise) else None

    def shot(self, exposure: Exposure, depth: bool = False) -> Shot:
        """Return what is to be drawn of an exposure; depth: whether its depths are wanted too."""
        return Shot(self.camera, exposure.camera_pose, depth)

    def add_noise(self, image: np.ndarray, number: int) -> None:
        """Add the noise of the camera to an image, uint8 RGB (height, width, 3), in place.

        number: of the image; each has another noise.
        """
        if self._noise is not None:
            self._noise.add(image, number)


class Drawing:
    """Draws cameras of a simulation in this process.

    poses: returns those of all parts now, (n, 7), for a RobotCamera; missing: a line for each
    visual that cannot be drawn.
    """

    def __init__(self, simulator: Simulator, drawn_by: Any = None):
        """Load the scene; drawn_by: a renderer that nothing else uses meanwhile, else a new one.

        Raises UserError if nothing can be drawn.
        """
        parts = Parts(simulator)
        self.poses = parts.poses
        self._renderer = drawn_by or renderer.make()
        self.missing = self._renderer.load(parts.scene(), parts.poses())

    def image(self, camera: DrawnCamera, exposure: Exposure, number: int,
              light: Optional[LightFilter] = None) -> np.ndarray:
        """Return an image, uint8 RGB (height, width, 3); number: of its noise."""
        shot = camera.shot(exposure)
        image = lens_views.draw(self._renderer, shot.camera, shot.pose, exposure.poses)
        if light is not None:
            light.apply(image)
        camera.add_noise(image, number)
        return image


def _calibration(settings: CameraSettings, camera: Camera) -> Optional[Calibration]:
    """Return the calibration of a camera.

    The focal length in P is that in K. The baseline is that of libgazebo_ros_camera's
    hackBaseline: P has -fx times it in its fourth column.
    """
    model = lens_views.model_of(camera)
    if model is None:
        return None
    fx, fy, cx, cy = model.intrinsics
    return Calibration(
        '', settings.camera_width, settings.camera_height, model.model, model.coefficients,
        (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        (fx, 0.0, cx, 0.0 - fx * settings.camera_baseline, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0))


def within(depths: np.ndarray, limits: Tuple[float, float]) -> np.ndarray:
    """Return depths, NaN for those that have no point, as in Gazebo.

    depths: float32, in m, +inf for nothing; limits: the smallest and the largest one that is told
    (pointCloudCutoff and pointCloudCutoffMax of gazebo_plugins).
    """
    return np.where((depths > limits[0]) & (depths < limits[1]), depths, np.float32(np.nan))


def depths_to_bytes(depths: np.ndarray, encoding: str) -> np.ndarray:
    """Return the bytes (height, width, n) of an image of depths.

    depths: float32, in m, NaN for nothing. In 16UC1, that and what is 65.5 m away are 0.

    >>> depths_to_bytes(np.array([[1.5, np.nan]], np.float32), '16UC1').view(np.uint16).tolist()
    [[[1500], [0]]]
    """
    if encoding == MILLIMETERS:
        depths = np.round(depths * 1000)
        depths = np.where(depths < 1 << 16, depths, 0).astype(np.uint16)
    return depths.view(np.uint8).reshape(*depths.shape, -1)


def cloud_without_points(depths: np.ndarray, header: Header) -> PointCloud2:
    """Return a message for a point with a color for each pixel, without data.

    depths: float32 (height, width), NaN for nothing.
    """
    height, width = depths.shape
    return PointCloud2(header=header, height=height, width=width, fields=list(_FIELDS),
                       is_bigendian=sys.byteorder == 'big', point_step=POINT_BYTES,
                       row_step=POINT_BYTES * width, is_dense=not np.isnan(depths).any())


def draw_points(result: np.ndarray, depths: np.ndarray, image: np.ndarray,
                slopes: Tuple[np.ndarray, np.ndarray]) -> None:
    """Write the data of such a message; NaN is nothing.

    result: uint8 (height, width, POINT_BYTES); depths: float32 (height, width), m along the
    optical axis, NaN for nothing; image: uint8 RGB; slopes: x to the right and y downward of what
    each pixel sees, at z 1, float32 (height, width).
    """
    x, y = (cv2.multiply(depths, slope) for slope in slopes)
    color = cv2.cvtColor(image, cv2.COLOR_RGB2BGRA)
    color[..., 3] = 0
    # one pass over all points: they are much more memory than what they are made of; -1 is zero
    cv2.mixChannels([x, y, depths, color.view(np.float32)], [result.view(np.float32)],
                    [0, 0, 1, 1, 2, 2, -1, 3, 3, 4, -1, 5, -1, 6, -1, 7])


def points_from_msg(msg: PointCloud2) -> Tuple[np.ndarray, np.ndarray]:
    """Return the points (height, width, 3) in m of such a message, and their colors, uint8 RGB."""
    points = np.frombuffer(msg.data, _POINT).reshape(msg.height, msg.width)
    return points['xyz'], points['bgr'][..., ::-1]
