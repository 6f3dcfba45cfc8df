"""Cameras: what an image shows."""
import math
from typing import NamedTuple, Optional, Union

from img_recog.formats.lenses import AnyLens


class ImageEdges(NamedTuple):
    """The edges of the image of a pinhole camera, as slopes to its optical axis: x is to the
    right, y upward.
    """

    left: float
    right: float
    bottom: float
    top: float


class Intrinsics(NamedTuple):
    """Focal lengths and principal point in pixels; the center of the first pixel is at 0, 0."""

    fx: float
    fy: float
    cx: float
    cy: float


class View(NamedTuple):
    """The image of a pinhole camera, whose optical axis need not be in its middle.

    width, height: pixels. near, far: m along the optical axis; what is nearer or farther is not
    drawn.
    """

    width: int
    height: int
    edges: ImageEdges
    near: float
    far: float


class Camera(NamedTuple):
    """A camera with square pixels and the optical axis in the middle of the image.

    width, height, near, far: as of a View. horizontal_fov: rad, from the left edge to the right
    edge of the image; lens: None for a pinhole camera without distortion. The field of view of a
    lens is that of the lens; that of a distortion is that of the camera without it.
    """

    width: int
    height: int
    horizontal_fov: float
    near: float = 0.05
    far: float = 100.0
    lens: Optional[AnyLens] = None

    @property
    def edges(self) -> ImageEdges:
        """The edges of the image without the lens.

        >>> [round(slope, 6) for slope in Camera(640, 480, 2 * math.atan(2)).edges]
        [-2.0, 2.0, -1.5, 1.5]
        """
        x = math.tan(self.horizontal_fov / 2)
        y = x * self.height / self.width
        return ImageEdges(-x, x, -y, y)

    @property
    def intrinsics(self) -> Intrinsics:
        """The intrinsic parameters without the lens, those of K in sensor_msgs/CameraInfo.

        >>> [round(value, 6) for value in Camera(640, 480, 2 * math.atan(2)).intrinsics]
        [160.0, 160.0, 319.5, 239.5]
        """
        return self.with_focal_length(self.width / 2 / math.tan(self.horizontal_fov / 2))

    def with_focal_length(self, focal_px: float) -> Intrinsics:
        """Return the intrinsic parameters for a focal length."""
        return Intrinsics(focal_px, focal_px, (self.width - 1) / 2, (self.height - 1) / 2)


Pinhole = Union[Camera, View]       # what a renderer draws: without a lens
