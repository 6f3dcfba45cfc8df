"""Camera calibrations: their files (of camera_calibration_parsers), and other image sizes."""
import dataclasses
import math
import os
import re
import reprlib
from dataclasses import dataclass
from typing import Any, Callable, Dict, Mapping, Optional, Tuple

import yaml

from img_recog.errors import UserError, one_line, shortened
from img_recog.files import atomic_write, plain
from img_recog.formats.markup import read_bytes
from img_recog.formats.yaml_text import load_yaml

_MAX_BYTES = 1 << 20        # a calibration file has some 2,000 bytes
_MODE = 0o644
# by the field of Calibration: its key in the file, rows, and columns, None for any number of them
_MATRICES = {
    'camera_matrix': ('camera_matrix', 3, 3),
    'distortion': ('distortion_coefficients', 1, None),
    'rectification': ('rectification_matrix', 3, 3),
    'projection': ('projection_matrix', 3, 4),
}
# models: sensor_msgs/distortion_models.h; the numbers of coefficients that OpenCV accepts for each
# besides none
_COEFFICIENT_COUNTS = {
    'equidistant': (4,),
    'plumb_bob': (5, 4),
    'rational_polynomial': (8, 12, 14),
}
# of OpenCV's FileStorage: its first line, which is no YAML, and its tag of a matrix
_FILE_STORAGE = re.compile(rb'\A%YAML:1\.0|!!opencv-matrix\b')
# Cameras round image sizes, such as 854x480 for 16:9: the aspect ratio is off by less than this.
_ASPECT_TOLERANCE = 0.01


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


def scaled(calibration: Calibration, width: int, height: int) -> Calibration:
    """Return the calibration for images of another size with the same field of view.

    Focal lengths and principal points are in pixels and scale with the image
    (sensor_msgs/CameraInfo); the distortion coefficients have no unit.
    Raises CalibrationError when the aspect ratio differs: the images may be cropped anywhere.

    >>> k, p = (500, 0, 320, 0, 500, 240, 0, 0, 1), (500, 0, 320, 0, 0, 500, 240, 0, 0, 0, 1, 0)
    >>> small = scaled(Calibration('', 640, 480, 'plumb_bob', (0,) * 5, k, (0,) * 9, p), 320, 240)
    >>> small.camera_matrix
    (250.0, 0.0, 160.0, 0.0, 250.0, 120.0, 0.0, 0.0, 1.0)
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

    def rows(matrix: Tuple[float, ...], columns: int) -> Tuple[float, ...]:
        factors = [x_factor] * columns + [y_factor] * columns + [1.0] * columns
        return tuple(value * factor for value, factor in zip(matrix, factors))
    return dataclasses.replace(calibration, width=width, height=height,
                               camera_matrix=rows(calibration.camera_matrix, 3),
                               projection=rows(calibration.projection, 4))


def check(calibration: Calibration) -> None:
    """Raise CalibrationError when images cannot be rectified with a calibration.

    The error names the entry of the file, what it has and what is wanted.
    """
    try:
        _check(calibration)
    except ValueError as error:
        raise CalibrationError('the calibration has no usable entry {}'.format(error))


def load(path: str, warn: Callable[[str], None] = lambda _: None) -> Calibration:
    """Read a calibration file.

    warn: called with one line that names what the file does not state and is assumed.
    Raises FileNotFoundError when it does not exist, and CalibrationError naming the file and the
    entry when it is not a calibration, or not one that `check` accepts.
    """
    try:
        content = load_yaml(_FILE_STORAGE.sub(b'', read_bytes(path, _MAX_BYTES, plain)))
    except FileNotFoundError:
        raise
    except (OSError, UserError) as error:
        raise CalibrationError('cannot read calibration {}: {}'.format(path, one_line(error)))
    if not isinstance(content, Mapping):
        raise CalibrationError(
            'calibration {} has no camera_matrix and other entries'.format(path),
            'write one with camera_calibration')
    try:
        loaded = _parse(content)
        _check(loaded)
    except ValueError as error:
        raise CalibrationError('calibration {} has no usable entry {}'.format(path, error))
    assumed = []
    if 'distortion_model' not in content:
        assumed.append('no distortion_model, assuming ' + loaded.distortion_model)
    if not loaded.distortion:
        assumed.append('no distortion_coefficients, assuming an image without distortion')
    if assumed:
        warn('calibration {} has {}'.format(path, ', and '.join(assumed)))
    return loaded


def save(path: str, calibration: Calibration) -> None:
    """Write a calibration file atomically; the target of a symlink is written.

    Raises CalibrationError naming the file when it cannot be written.
    """
    content: Dict[str, Any] = {
        'image_width': calibration.width,
        'image_height': calibration.height,
        'camera_name': calibration.camera_name,
        'distortion_model': calibration.distortion_model,
    }
    for field, (key, rows, columns) in _MATRICES.items():
        data = [float(value) for value in getattr(calibration, field)]
        content[key] = {'rows': rows, 'cols': columns or len(data), 'data': data}
    target = os.path.realpath(path)
    try:
        os.makedirs(os.path.dirname(target), exist_ok=True)
        with atomic_write((target,), advice='') as (file,):
            text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None)
            file.write(text.encode())
            os.fchmod(file.fileno(), _MODE)
    except (OSError, UserError) as error:
        # atomic_write names the file itself; its cause is the error of the system
        raise CalibrationError('cannot write calibration {}: {}'.format(
            path, one_line(error.__cause__ or error)))


def _check(calibration: Calibration) -> None:
    """Raise the problem of the first entry that is not usable."""
    for key, size in (('image_width', calibration.width), ('image_height', calibration.height)):
        if size <= 0:
            raise _problem(key, 'a whole number above 0', size)
    for field, (key, _, _) in _MATRICES.items():
        for value in getattr(calibration, field):
            if not math.isfinite(value):
                raise _problem(key, 'finite numbers', value)
    model, count = calibration.distortion_model, len(calibration.distortion)
    if model not in _COEFFICIENT_COUNTS:
        raise _problem('distortion_model', 'one of ' + ', '.join(sorted(_COEFFICIENT_COUNTS)),
                       model)
    if count not in (0, *_COEFFICIENT_COUNTS[model]):
        raise _problem('distortion_coefficients', '{} numbers for {}'.format(
            ' or '.join(map(str, _COEFFICIENT_COUNTS[model])), model), count)
    for name, index in (('fx', 0), ('fy', 4)):
        if calibration.camera_matrix[index] <= 0.0:
            raise _problem('camera_matrix', 'a focal length {} above 0'.format(name),
                           calibration.camera_matrix[index])


def _parse(content: Mapping[str, Any]) -> Calibration:
    """Return the calibration in a file; raise the problem of the first entry that is wrong."""
    name = content.get('camera_name')
    if isinstance(name, (list, dict, set)):
        raise _problem('camera_name', 'a text', name)
    width, height = (_entry(content, key, int, 'a whole number')
                     for key in ('image_width', 'image_height'))
    values = {field: _values(content, *matrix) for field, matrix in _MATRICES.items()}
    if 'distortion_model' in content:
        model = _entry(content, 'distortion_model', str, 'a text')
    else:       # camera_calibration_parsers assumes plumb_bob
        is_rational = len(values['distortion']) in _COEFFICIENT_COUNTS['rational_polynomial']
        model = 'rational_polynomial' if is_rational else 'plumb_bob'
    return Calibration(camera_name='' if name is None else str(name), width=width, height=height,
                       distortion_model=model, **values)


def _entry(content: Mapping[str, Any], key: str, wanted_type: type, wanted: str) -> Any:
    value = content.get(key)
    # bool is a subclass of int, so isinstance would accept True for a width of 1
    if type(value) is not wanted_type:
        raise _problem(key, wanted, value)
    return value


def _values(content: Mapping[str, Any], key: str, rows: int,
            columns: Optional[int]) -> Tuple[float, ...]:
    entry = _entry(content, key, dict, 'rows, cols and data')
    data = _entry(entry, 'data', list, 'the numbers of {}'.format(key))
    count = len(data)
    if columns is not None and count != rows * columns:
        raise _problem(key, '{} numbers'.format(rows * columns), count)
    # a vector may be a row or a column, and an empty one 0x0
    shapes = [(1, count), (count, 1)] if columns is None else [(rows, columns)]
    shapes += [(0, 0)] * (count == 0)
    shape = entry.get('rows', shapes[0][0]), entry.get('cols', shapes[0][1])
    if shape not in shapes:
        raise _problem(key, 'rows: {}, cols: {}'.format(*shapes[0]), shape)
    return tuple(_number(key, value) for value in data)


def _number(key: str, value: Any) -> float:
    try:
        if isinstance(value, bool):
            raise TypeError
        # yaml-cpp writes 1e-05, which is a string in YAML 1.1
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise _problem(key, 'numbers', value)


def _problem(key: str, wanted: str, value: object) -> ValueError:
    # an alias can make a small text a value of any size
    return ValueError('{} (wants {}, has {})'.format(key, wanted, shortened(reprlib.repr(value))))
