"""Camera calibration files in the YAML layout of camera_calibration_parsers."""
import dataclasses
import os
import tempfile
from dataclasses import dataclass
from typing import Any, Mapping, Tuple

import yaml

from img_recog.errors import UserError


class CalibrationError(UserError):
    """A calibration file cannot be read, written or understood."""


@dataclass(frozen=True)
class Calibration:
    """An intrinsic calibration, with the meanings of sensor_msgs/CameraInfo.

    width, height: pixels of the images it was made with; distortion: D for `distortion_model`.
    camera_matrix: K, 3x3 row by row; rectification: R, 3x3; projection: P, 3x4.
    """

    camera_name: str
    width: int
    height: int
    distortion_model: str
    distortion: Tuple[float, ...]
    camera_matrix: Tuple[float, ...]
    rectification: Tuple[float, ...]
    projection: Tuple[float, ...]


# field of Calibration -> (key in the file, rows, columns); no columns: as many as there are
_MATRICES = {
    'camera_matrix': ('camera_matrix', 3, 3),
    'distortion': ('distortion_coefficients', 1, None),
    'rectification': ('rectification_matrix', 3, 3),
    'projection': ('projection_matrix', 3, 4),
}


# sizes that a camera rounds, such as 854x480 for 16:9, are off by less than this
_ASPECT_TOLERANCE = 0.01


def scaled(calibration: Calibration, width: int, height: int) -> Calibration:
    """Return the calibration for images of another size that show the same.

    Focal lengths and centres are in pixels and grow with the image (sensor_msgs/CameraInfo); the
    distortion has no unit.
    Raises CalibrationError when the aspect ratio is another: then nobody knows what was cut off.
    """
    if (width, height) == (calibration.width, calibration.height):
        return calibration
    across = width / calibration.width if calibration.width > 0 else 0.0
    down = height / calibration.height if calibration.height > 0 else 0.0
    if across <= 0.0 or down <= 0.0 or abs(across / down - 1.0) > _ASPECT_TOLERANCE:
        raise CalibrationError('the calibration is for {}x{}, the images are {}x{}, another shape'
                               .format(calibration.width, calibration.height, width, height))
    return dataclasses.replace(
        calibration, width=width, height=height,
        camera_matrix=_rows_scaled(calibration.camera_matrix, 3, across, down),
        projection=_rows_scaled(calibration.projection, 4, across, down))


def load(path: str) -> Calibration:
    """Read a calibration file.

    Raises FileNotFoundError when there is none, and CalibrationError naming the file and the
    entry when it cannot be read as a calibration.
    """
    try:
        with open(path) as file:
            content = yaml.safe_load(file)
    except FileNotFoundError:
        raise
    # ValueError: bytes that are no text, and dates that do not exist
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise CalibrationError('cannot read calibration {}: {}'.format(path, _one_line(error)))
    if not isinstance(content, Mapping):
        raise CalibrationError('calibration {} holds no camera_matrix and other entries; write '
                               'one with camera_calibration'.format(path))
    try:
        return Calibration(
            camera_name=str(content.get('camera_name', '')),
            width=_entry(content, 'image_width', int, 'a whole number'),
            height=_entry(content, 'image_height', int, 'a whole number'),
            distortion_model=_entry(content, 'distortion_model', str, 'a text'),
            **{field: _matrix(content, *shape) for field, shape in _MATRICES.items()})
    except ValueError as error:
        raise CalibrationError('calibration {} has no usable entry {}'.format(path, error))


def save(path: str, calibration: Calibration) -> None:
    """Write a calibration file, whole or not at all.

    Raises CalibrationError naming the file when it cannot be written.
    """
    content = {
        'image_width': calibration.width,
        'image_height': calibration.height,
        'camera_name': calibration.camera_name,
        'distortion_model': calibration.distortion_model,
    }
    for field, (key, rows, columns) in _MATRICES.items():
        data = [float(value) for value in getattr(calibration, field)]
        content[key] = {'rows': rows, 'cols': columns or len(data), 'data': data}
    folder = os.path.dirname(os.path.abspath(path))
    try:
        os.makedirs(folder, exist_ok=True)
        handle, scratch = tempfile.mkstemp(dir=folder, prefix='.calibration-')
        try:
            with os.fdopen(handle, 'w') as file:
                yaml.safe_dump(content, file, sort_keys=False, default_flow_style=None)
            os.chmod(scratch, 0o644)
            os.replace(scratch, path)
        except BaseException:
            os.unlink(scratch)
            raise
    except OSError as error:
        raise CalibrationError('cannot write calibration {}: {}'.format(path, error.strerror))


def _rows_scaled(matrix: Tuple[float, ...], columns: int, across: float,
                 down: float) -> Tuple[float, ...]:
    factors = [across] * columns + [down] * columns + [1.0] * columns
    return tuple(value * factor for value, factor in zip(matrix, factors))


def _entry(content: Mapping[str, Any], key: str, kind: type, words: str) -> Any:
    value = content.get(key)
    if type(value) is not kind:
        raise ValueError('{} (wants {}, has {!r})'.format(key, words, value))
    return value


def _matrix(content: Mapping[str, Any], key: str, rows: int, columns) -> Tuple[float, ...]:
    data = _entry(_entry(content, key, dict, 'rows, cols and data'), 'data', list,
                  'the numbers of {}'.format(key))
    if columns is not None and len(data) != rows * columns:
        raise ValueError('{} (wants {} numbers, has {})'.format(key, rows * columns, len(data)))
    try:
        # float, since YAML 1.1 takes 1e-05, as yaml-cpp writes it, for a text
        return tuple(float(value) for value in data)
    except (TypeError, ValueError, OverflowError) as error:
        raise ValueError('{} ({})'.format(key, error))


def _one_line(error: Exception) -> str:
    return ' '.join(str(error).split())
