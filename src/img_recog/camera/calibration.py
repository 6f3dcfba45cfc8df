"""Camera calibration files in the YAML layout of camera_calibration_parsers."""
import dataclasses
import errno
import math
import os
import reprlib
import stat
import tempfile
from dataclasses import dataclass
from typing import Any, Mapping, Tuple

import yaml

from img_recog.errors import UserError

# of a calibration there are two thousand; more is something else
_MOST_BYTES = 1 << 20
_MOST_LETTERS = 200


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


# sensor_msgs/distortion_models.h, and how many coefficients of each OpenCV takes
_DISTORTIONS = {
    'equidistant': (4,),
    'plumb_bob': (5, 4),
    'rational_polynomial': (8, 12, 14),
}

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

    Focal lengths and centers are in pixels and grow with the image (sensor_msgs/CameraInfo); the
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


def check(calibration: Calibration) -> None:
    """Refuse a calibration that nobody can rectify an image with.

    Raises CalibrationError naming the entry, what it has and what is wanted.
    """
    try:
        _check(calibration)
    except ValueError as error:
        raise CalibrationError('the calibration has no usable entry {}'.format(error))


def load(path: str) -> Calibration:
    """Read a calibration file.

    Raises FileNotFoundError when there is none, and CalibrationError naming the file and the
    entry when it cannot be read as a calibration, or is none that `check` accepts.
    """
    try:
        content = yaml.safe_load(_text(path))
    except FileNotFoundError:
        raise
    except RecursionError:
        raise CalibrationError('cannot read calibration {}: nested too deeply'.format(path))
    # ValueError: bytes that are no text, and dates that do not exist
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise CalibrationError('cannot read calibration {}: {}'.format(path, _one_line(error)))
    if not isinstance(content, Mapping):
        raise CalibrationError('calibration {} holds no camera_matrix and other entries; write '
                               'one with camera_calibration'.format(path))
    try:
        loaded = Calibration(
            camera_name=_camera_name(content),
            width=_entry(content, 'image_width', int, 'a whole number'),
            height=_entry(content, 'image_height', int, 'a whole number'),
            distortion_model=_entry(content, 'distortion_model', str, 'a text'),
            **{field: _matrix(content, *shape) for field, shape in _MATRICES.items()})
        _check(loaded)
        return loaded
    except ValueError as error:
        raise CalibrationError('calibration {} has no usable entry {}'.format(path, error))


def save(path: str, calibration: Calibration) -> None:
    """Write a calibration file, whole or not at all; through a link to the file it stands for.

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
    target = os.path.realpath(path)
    folder = os.path.dirname(target)
    try:
        _refuse_special(target)
        os.makedirs(folder, exist_ok=True)
        handle, scratch = tempfile.mkstemp(dir=folder, prefix='.calibration-')
        try:
            with os.fdopen(handle, 'w') as file:
                yaml.safe_dump(content, file, sort_keys=False, default_flow_style=None)
            os.chmod(scratch, 0o644)
            os.replace(scratch, target)
        except BaseException:
            os.unlink(scratch)
            raise
    except OSError as error:
        raise CalibrationError('cannot write calibration {}: {}'.format(path, error.strerror))


def _rows_scaled(matrix: Tuple[float, ...], columns: int, across: float,
                 down: float) -> Tuple[float, ...]:
    factors = [across] * columns + [down] * columns + [1.0] * columns
    return tuple(value * factor for value, factor in zip(matrix, factors))


def _text(path: str) -> bytes:
    _refuse_special(path)       # to open a pipe would wait for whoever writes into it
    with open(path, 'rb') as file:
        text = file.read(_MOST_BYTES + 1)
    if len(text) > _MOST_BYTES:
        raise ValueError('larger than {} bytes'.format(_MOST_BYTES))
    return text


def _refuse_special(path: str) -> None:
    """Raise OSError for what is there and no file: a device, pipe, folder or the like."""
    if os.path.lexists(path) and not stat.S_ISREG(os.stat(path).st_mode):
        raise OSError(errno.EINVAL, 'not a regular file')


def _camera_name(content: Mapping[str, Any]) -> str:
    name = content.get('camera_name')
    if isinstance(name, (list, dict, set)):
        raise ValueError('camera_name (wants a text, has {})'.format(_SHORT.repr(name)))
    return '' if name is None else str(name)


def _entry(content: Mapping[str, Any], key: str, kind: type, words: str) -> Any:
    value = content.get(key)
    if type(value) is not kind:
        raise ValueError('{} (wants {}, has {})'.format(key, words, _SHORT.repr(value)))
    return value


def _matrix(content: Mapping[str, Any], key: str, rows: int, columns) -> Tuple[float, ...]:
    matrix = _entry(content, key, dict, 'rows, cols and data')
    data = _entry(matrix, 'data', list, 'the numbers of {}'.format(key))
    if columns is not None and len(data) != rows * columns:
        raise ValueError('{} (wants {} numbers, has {})'.format(key, rows * columns, len(data)))
    shape = matrix.get('rows', rows), matrix.get('cols', columns or len(data))
    # a vector may stand upright
    if columns is None and shape not in ((1, len(data)), (len(data), 1)):
        raise ValueError('{} (wants rows x cols numbers, has {} for {} x {})'.format(
            key, len(data), *map(_SHORT.repr, shape)))
    if columns is not None and shape != (rows, columns):
        raise ValueError('{} (wants rows: {}, cols: {}, has {}, {})'.format(
            key, rows, columns, *map(_SHORT.repr, shape)))
    return tuple(_number(key, value) for value in data)


def _number(key: str, value: Any) -> float:
    try:
        if isinstance(value, bool):
            raise TypeError
        # float, since YAML 1.1 takes 1e-05, as yaml-cpp writes it, for a text
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError('{} (wants numbers, has {})'.format(key, _SHORT.repr(value)))


def _check(calibration: Calibration) -> None:
    """Raise ValueError: the entry in the file, what is wanted of it and what it has."""
    for key, size in (('image_width', calibration.width), ('image_height', calibration.height)):
        if size <= 0:
            raise ValueError('{} (wants a whole number above 0, has {})'.format(key, size))
    for field, (key, _, _) in _MATRICES.items():
        for value in getattr(calibration, field):
            if not math.isfinite(value):
                raise ValueError('{} (wants finite numbers, has {})'.format(key, value))
    model, count = calibration.distortion_model, len(calibration.distortion)
    if model not in _DISTORTIONS:
        raise ValueError('distortion_model (wants one of {}, has {})'.format(
            ', '.join(sorted(_DISTORTIONS)), _SHORT.repr(model)))
    if count not in _DISTORTIONS[model]:
        raise ValueError('distortion_coefficients (wants {} numbers for {}, has {})'.format(
            ' or '.join(map(str, _DISTORTIONS[model])), model, count))
    for name, value in (('fx', calibration.camera_matrix[0]),
                        ('fy', calibration.camera_matrix[4])):
        if value <= 0.0:
            raise ValueError('camera_matrix (wants a focal length {} above 0, has {:g})'.format(
                name, value))


def _one_line(error: Exception) -> str:
    text = error.strerror if isinstance(error, OSError) and error.strerror else str(error)
    line = ' '.join(text[:10 * _MOST_LETTERS].split())
    return line if len(line) <= _MOST_LETTERS else line[:_MOST_LETTERS] + '...'


def _short() -> reprlib.Repr:
    short = reprlib.Repr()
    short.maxlevel, short.maxlist, short.maxdict = 2, 3, 3
    short.maxstring = short.maxlong = short.maxother = 60
    return short


_SHORT = _short()
