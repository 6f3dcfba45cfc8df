"""What draws a camera on a simulated robot, and what its camera info says."""
from typing import Optional

from img_recog.camera.calibration import Calibration
from img_recog.rendering import rays
from img_recog.rendering.camera import Camera
from img_recog.rendering.noise import PixelNoise
from img_recog.simulation.settings import CameraSettings


def camera_of(settings: CameraSettings) -> Camera:
    """Return the camera that draws what a simulated one sees."""
    return Camera(settings.camera_width, settings.camera_height, settings.camera_horizontal_fov,
                  settings.camera_near, settings.camera_far, settings.lens)


def noise_of(settings: CameraSettings) -> Optional[PixelNoise]:
    """Return what adds the noise of a simulated camera to its images, None if it has none."""
    given = settings.camera_noise, settings.camera_noise_mean
    return PixelNoise(*given) if any(given) else None


def calibration_of(settings: CameraSettings) -> Optional[Calibration]:
    """Return the calibration of a simulated camera, None if its lens has none.

    The focal length in P is that in K. The baseline is that of libgazebo_ros_camera's
    hackBaseline: P has -fx times it in its fourth column.
    """
    model = rays.model_of(camera_of(settings))
    if model is None:
        return None
    fx, fy, cx, cy = model.intrinsics
    return Calibration(
        '', settings.camera_width, settings.camera_height, model.model, model.coefficients,
        (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        (fx, 0.0, cx, 0.0 - fx * settings.camera_baseline, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0))
