"""A pinhole camera."""
import math
from typing import NamedTuple


class Intrinsics(NamedTuple):
    """Focal lengths and principal point in pixels; the center of the first pixel is at 0, 0."""

    fx: float
    fy: float
    cx: float
    cy: float


class Camera(NamedTuple):
    """A camera with square pixels and without distortion.

    width, height: pixels. horizontal_fov: rad, from the left edge to the right edge of the image.
    near, far: m along the optical axis; what is nearer or farther is not drawn.
    """

    width: int
    height: int
    horizontal_fov: float
    near: float = 0.05
    far: float = 100.0

    @property
    def slopes(self) -> 'tuple[float, float]':
        """The tangents of half the horizontal and half the vertical field of view.

        >>> tuple(round(slope, 6) for slope in Camera(640, 480, 2 * math.atan(2)).slopes)
        (2.0, 1.5)
        """
        slope = math.tan(self.horizontal_fov / 2)
        return slope, slope * self.height / self.width

    @property
    def intrinsics(self) -> Intrinsics:
        """The intrinsic parameters, those of K in sensor_msgs/CameraInfo.

        >>> [round(value, 6) for value in Camera(640, 480, 2 * math.atan(2)).intrinsics]
        [160.0, 160.0, 319.5, 239.5]
        """
        focal_px = self.width / 2 / math.tan(self.horizontal_fov / 2)
        return Intrinsics(focal_px, focal_px, (self.width - 1) / 2, (self.height - 1) / 2)
