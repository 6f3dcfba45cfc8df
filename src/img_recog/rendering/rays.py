"""What each pixel of a camera looks at, and the model that says it."""
import functools
from typing import NamedTuple, Optional, Tuple

import cv2
import numpy as np

from img_recog.formats.lenses import ID, TAN, Distortion, Lens
from img_recog.rendering.camera import Camera, Intrinsics

PLUMB_BOB, EQUIDISTANT = 'plumb_bob', 'equidistant'     # sensor_msgs/distortion_models.h
_UNDISTORTED = (0.0,) * 5   # for plumb_bob
_MAX_ERROR_PX = 0.5         # of a model
_SAMPLES = 200
_POWERS = 3, 5, 7, 9        # of the angle, that k1 to k4 belong to
_CRITERIA = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)


class CameraModel(NamedTuple):
    """The distortion model of sensor_msgs/CameraInfo, its D, and what K is made of."""

    model: str
    coefficients: Tuple[float, ...]
    intrinsics: Intrinsics


@functools.lru_cache(maxsize=32)
def directions(camera: Camera) -> np.ndarray:
    """Return the unit vectors (height, width, 3) along which pixels look, NaN for black ones.

    In the optical frame: x to the right, y downward, z forward (REP 103). It must not be changed.
    """
    width, height = camera.width, camera.height
    x, y = np.meshgrid(2 * np.arange(width) + 1 - width, 2 * np.arange(height) + 1 - height)
    x, y = x / width, y / width         # in halves of the width
    lens = camera.lens
    if isinstance(lens, Lens):
        radius = np.hypot(x, y)
        angle = lens.angle(radius)
        share = np.sin(angle) / np.maximum(radius, 1e-12)
        found = np.stack([share * x, share * y, np.cos(angle)], axis=-1)
    else:
        slope = camera.edges.right
        found = np.stack([slope * x, slope * y, np.ones_like(x)], axis=-1)
        if lens is not None:
            found = _undistorted(found, lens, camera.intrinsics.fx)
        found /= np.linalg.norm(found, axis=-1, keepdims=True)
    found.flags.writeable = False
    return found


@functools.lru_cache(maxsize=32)
def slopes(camera: Camera) -> Tuple[np.ndarray, np.ndarray]:
    """Return x and y of these directions at z 1, float32 (height, width). Do not change them."""
    found = directions(camera)
    x, y = ((found[..., axis] / found[..., 2]).astype(np.float32) for axis in (0, 1))
    return x, y


def _undistorted(found: np.ndarray, lens: Distortion, focal_px: float) -> np.ndarray:
    """Return the directions (height, width, 3), with z 1, that a distortion moves to `found`."""
    given = found[..., :2].reshape(-1, 1, 2)
    coefficients = np.array(lens)
    undistorted = cv2.undistortPointsIter(given, np.eye(3), coefficients, np.eye(3), np.eye(3),
                                          _CRITERIA)
    points = cv2.convertPointsToHomogeneous(undistorted)
    again, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), coefficients)
    # no direction is seen at a place that the polynomial does not reach
    wrong = np.abs(again - given).max(axis=2).ravel() * focal_px > _MAX_ERROR_PX
    points[wrong | ~np.isfinite(again).all(axis=2).ravel()] = np.nan
    return points.reshape(found.shape)


def model_of(camera: Camera) -> Optional[CameraModel]:
    """Return the model of a camera, None if no model can say what its lens does.

    A Lens that is not a pinhole is said by the model equidistant, also known as fisheye: a
    direction at an angle t is seen t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8) focal lengths from
    the principal point. The coefficients are 0 for the function id, and else the nearest for the
    angles in the image.
    """
    lens = camera.lens
    if not isinstance(lens, Lens):
        return CameraModel(PLUMB_BOB, tuple(lens or _UNDISTORTED), camera.intrinsics)
    focal_px = camera.width / 2 * lens.scale / lens.divisor
    intrinsics = camera.with_focal_length(focal_px)
    if lens.offset:
        return None         # its middle is not a point
    if lens.function == TAN and lens.divisor == 1:
        return CameraModel(PLUMB_BOB, _UNDISTORTED, intrinsics)
    if lens.function == ID:
        return CameraModel(EQUIDISTANT, (0.0,) * 4, intrinsics)
    z = directions(camera)[..., 2]
    if np.isnan(z).all():
        return None
    share = np.arange(1, _SAMPLES + 1) / _SAMPLES
    angle = share * np.arccos(np.nanmin(z))
    rest = camera.width / 2 * lens.radius(angle) - focal_px * angle
    columns = np.stack([share ** power for power in _POWERS], axis=1)
    factors = np.linalg.lstsq(columns, rest, rcond=None)[0]
    if np.abs(columns @ factors - rest).max() > _MAX_ERROR_PX:
        return None
    coefficients = factors / focal_px / angle[-1] ** np.array(_POWERS)
    return CameraModel(EQUIDISTANT, tuple(coefficients.tolist()), intrinsics)
