"""Camera calibrations: their model, what makes one usable, and scaling to another image size."""
import dataclasses
import math
import reprlib
from dataclasses import dataclass
from typing import NamedTuple, Optional, Tuple

from img_recog.errors import UserError


class CalibrationError(UserError):
    """A calibration is not usable, or its file cannot be read or written."""


@dataclass(frozen=True)
class Calibration:
    """An intrinsic calibration, with the meanings of sensor_msgs/CameraInfo.

    width, height: of the images that it was made with, in pixels.
    distortion: the coefficients D of `distortion_model`.
    camera_matrix: K, 3x3 in row-major order; rectification: R, 3x3; projection: P, 3x4.
    """

    camera_name: str
    width: int
    height: int
    distortion_model: str
    distortion: Tuple[float, ...]
    camera_matrix: Tuple[float, ...]
    rectification: Tuple[float, ...]
    projection: Tuple[float, ...]


class Matrix(NamedTuple):
    """How a matrix is stored in a calibration file; columns is None for any number of them."""

    key: str
    rows: int
    columns: Optional[int]


# by the field of Calibration
MATRICES = {
    'camera_matrix': Matrix('camera_matrix', 3, 3),
    'distortion': Matrix('distortion_coefficients', 1, None),
    'rectification': Matrix('rectification_matrix', 3, 3),
    'projection': Matrix('projection_matrix', 3, 4),
}

# models: sensor_msgs/distortion_models.h; the numbers of coefficients that OpenCV accepts for each
_COEFFICIENT_COUNTS = {
    'equidistant': (4,),
    'plumb_bob': (5, 4),
    'rational_polynomial': (8, 12, 14),
}

# Cameras round image sizes, such as 854x480 for 16:9: the aspect ratio is off by less than this.
_ASPECT_TOLERANCE = 0.01


def scaled(calibration: Calibration, width: int, height: int) -> Calibration:
    """Return the calibration for images of another size with the same field of view.

    Focal lengths and principal points are in pixels and scale with the image
    (sensor_msgs/CameraInfo); the distortion coefficients have no unit.
    Raises CalibrationError when the aspect ratio differs: the images may be cropped anywhere.
    """
    if (width, height) == (calibration.width, calibration.height):
        return calibration
    x_factor = width / calibration.width if calibration.width > 0 else 0.0
    y_factor = height / calibration.height if calibration.height > 0 else 0.0
    if (x_factor <= 0.0 or y_factor <= 0.0
            or abs(x_factor / y_factor - 1.0) > _ASPECT_TOLERANCE):
        raise CalibrationError(
            'the calibration is for {}x{}, the images are {}x{}, another aspect ratio'.format(
                calibration.width, calibration.height, width, height))
    return dataclasses.replace(
        calibration, width=width, height=height,
        camera_matrix=_scale_rows(calibration.camera_matrix, 3, x_factor, y_factor),
        projection=_scale_rows(calibration.projection, 4, x_factor, y_factor))


def check(calibration: Calibration) -> None:
    """Raise CalibrationError when images cannot be rectified with a calibration.

    The error names the entry of the file, what it has and what is wanted.
    """
    problem = find_problem(calibration)
    if problem is not None:
        raise CalibrationError('the calibration has no usable entry ' + problem)


def find_problem(calibration: Calibration) -> Optional[str]:
    """Return the first entry that is not usable, what is wanted and what it has; None if all are.
    """
    for key, size in (('image_width', calibration.width), ('image_height', calibration.height)):
        if size <= 0:
            return '{} (wants a whole number above 0, has {})'.format(key, size)
    for field, matrix in MATRICES.items():
        for value in getattr(calibration, field):
            if not math.isfinite(value):
                return '{} (wants finite numbers, has {})'.format(matrix.key, value)
    model, count = calibration.distortion_model, len(calibration.distortion)
    if model not in _COEFFICIENT_COUNTS:
        return 'distortion_model (wants one of {}, has {})'.format(
            ', '.join(sorted(_COEFFICIENT_COUNTS)), short_repr(model))
    if count not in _COEFFICIENT_COUNTS[model]:
        return 'distortion_coefficients (wants {} numbers for {}, has {})'.format(
            ' or '.join(map(str, _COEFFICIENT_COUNTS[model])), model, count)
    for name, value in (('fx', calibration.camera_matrix[0]),
                        ('fy', calibration.camera_matrix[4])):
        if value <= 0.0:
            return 'camera_matrix (wants a focal length {} above 0, has {:g})'.format(name, value)
    return None


def short_repr(value: object) -> str:
    """Return the representation of a value from a file, short whatever the value is."""
    return _REPR.repr(value)


def _scale_rows(matrix: Tuple[float, ...], columns: int, x_factor: float,
                y_factor: float) -> Tuple[float, ...]:
    factors = [x_factor] * columns + [y_factor] * columns + [1.0] * columns
    return tuple(value * factor for value, factor in zip(matrix, factors))


def _limited_repr() -> reprlib.Repr:
    limited = reprlib.Repr()
    limited.maxlevel, limited.maxlist, limited.maxdict = 2, 3, 3
    limited.maxstring = limited.maxlong = limited.maxother = 60
    return limited


_REPR = _limited_repr()
