"""What draws the cameras of simulated robots, and what their camera info says."""
from typing import Any, Optional

import numpy as np

from img_recog.camera.calibration import Calibration
from img_recog.rendering import lens_views, rays, renderer
from img_recog.rendering.camera import Camera
from img_recog.rendering.light import LightFilter
from img_recog.rendering.noise import PixelNoise
from img_recog.rendering.server import Shot
from img_recog.simulation.pictures.visual_scene import Parts
from img_recog.simulation.sensors.robot_camera import Exposure
from img_recog.simulation.simulation_settings import CameraSettings
from img_recog.simulation.simulator import Simulator


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
    model = rays.model_of(camera)
    if model is None:
        return None
    fx, fy, cx, cy = model.intrinsics
    return Calibration(
        '', settings.camera_width, settings.camera_height, model.model, model.coefficients,
        (fx, 0.0, cx, 0.0, fy, cy, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0),
        (fx, 0.0, cx, 0.0 - fx * settings.camera_baseline, 0.0, fy, cy, 0.0, 0.0, 0.0, 1.0, 0.0))
