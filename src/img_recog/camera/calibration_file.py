"""Camera calibration files in the YAML format of camera_calibration_parsers."""
import errno
import os
import stat
from typing import Any, Dict, Mapping, Tuple

import yaml

from img_recog.camera.calibration import (MATRICES, Calibration, CalibrationError, Matrix,
                                          find_problem, short_repr)
from img_recog.errors import UserError, one_line
from img_recog.files import atomic_write
from img_recog.markup import MarkupError, load_yaml, read_bytes

_MAX_BYTES = 1 << 20        # a calibration file has some 2,000 bytes
_MODE = 0o644


def load(path: str) -> Calibration:
    """Read a calibration file.

    Raises FileNotFoundError when it does not exist, and CalibrationError naming the file and the
    entry when it is not a calibration, or not one that `check` accepts.
    """
    try:
        content = load_yaml(_read(path))
    except FileNotFoundError:
        raise
    except (OSError, MarkupError) as error:
        raise CalibrationError('cannot read calibration {}: {}'.format(path, one_line(error)))
    if not isinstance(content, Mapping):
        raise CalibrationError(
            'calibration {} has no camera_matrix and other entries'.format(path),
            'write one with camera_calibration')
    try:
        loaded = _parse(content)
        problem = find_problem(loaded)
    except ValueError as error:
        problem = str(error)
    if problem is not None:
        raise CalibrationError('calibration {} has no usable entry {}'.format(path, problem))
    return loaded


def save(path: str, calibration: Calibration) -> None:
    """Write a calibration file atomically; a symlink stays, and its target is written.

    Raises CalibrationError naming the file when it cannot be written.
    """
    content: Dict[str, Any] = {
        'image_width': calibration.width,
        'image_height': calibration.height,
        'camera_name': calibration.camera_name,
        'distortion_model': calibration.distortion_model,
    }
    for field, (key, rows, columns) in MATRICES.items():
        data = [float(value) for value in getattr(calibration, field)]
        content[key] = {'rows': rows, 'cols': columns or len(data), 'data': data}
    target = os.path.realpath(path)
    try:
        _refuse_special(target)
        os.makedirs(os.path.dirname(target), exist_ok=True)
        with atomic_write((target,), advice='') as (file,):
            text = yaml.safe_dump(content, sort_keys=False, default_flow_style=None)
            file.write(text.encode())
            os.fchmod(file.fileno(), _MODE)
    except (OSError, UserError) as error:
        # atomic_write names the file itself; its cause is the error of the system
        raise CalibrationError('cannot write calibration {}: {}'.format(
            path, one_line(error.__cause__ or error)))


def _read(path: str) -> bytes:
    _refuse_special(path)       # opening a pipe would wait for its writer
    return read_bytes(path, _MAX_BYTES)


def _refuse_special(path: str) -> None:
    """Raise OSError for a device, pipe, folder or the like."""
    if os.path.lexists(path) and not stat.S_ISREG(os.stat(path).st_mode):
        raise OSError(errno.EINVAL, 'not a regular file')


def _parse(content: Mapping[str, Any]) -> Calibration:
    """Return the calibration in a file; ValueError: the entry, what is wanted and what it has."""
    return Calibration(
        camera_name=_camera_name(content),
        width=_entry(content, 'image_width', int, 'a whole number'),
        height=_entry(content, 'image_height', int, 'a whole number'),
        distortion_model=_entry(content, 'distortion_model', str, 'a text'),
        **{field: _values(content, matrix) for field, matrix in MATRICES.items()})


def _camera_name(content: Mapping[str, Any]) -> str:
    name = content.get('camera_name')
    if isinstance(name, (list, dict, set)):
        raise ValueError('camera_name (wants a text, has {})'.format(short_repr(name)))
    return '' if name is None else str(name)


def _entry(content: Mapping[str, Any], key: str, wanted_type: type, wanted: str) -> Any:
    value = content.get(key)
    # bool is a subclass of int, so isinstance would accept True for a width of 1
    if type(value) is not wanted_type:
        raise ValueError('{} (wants {}, has {})'.format(key, wanted, short_repr(value)))
    return value


def _values(content: Mapping[str, Any], matrix: Matrix) -> Tuple[float, ...]:
    key, rows, columns = matrix
    entry = _entry(content, key, dict, 'rows, cols and data')
    data = _entry(entry, 'data', list, 'the numbers of {}'.format(key))
    if columns is not None and len(data) != rows * columns:
        raise ValueError('{} (wants {} numbers, has {})'.format(key, rows * columns, len(data)))
    shape = entry.get('rows', rows), entry.get('cols', columns or len(data))
    # a vector may be a row or a column
    if columns is None and shape not in ((1, len(data)), (len(data), 1)):
        raise ValueError('{} (wants rows x cols numbers, has {} for {} x {})'.format(
            key, len(data), *map(short_repr, shape)))
    if columns is not None and shape != (rows, columns):
        raise ValueError('{} (wants rows: {}, cols: {}, has {}, {})'.format(
            key, rows, columns, *map(short_repr, shape)))
    return tuple(_number(key, value) for value in data)


def _number(key: str, value: Any) -> float:
    try:
        if isinstance(value, bool):
            raise TypeError
        # yaml-cpp writes 1e-05, which is a string in YAML 1.1
        return float(value)
    except (TypeError, ValueError, OverflowError):
        raise ValueError('{} (wants numbers, has {})'.format(key, short_repr(value)))
