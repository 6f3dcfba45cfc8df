"""Refuses mesh files that PyBullet would read beyond their end, or report in lines of its own."""
import os
import struct
from xml.parsers import expat

import numpy as np

from img_recog.errors import one_line
from img_recog.simulation.descriptions import dae_check
from img_recog.simulation.descriptions.dae_check import DamagedMesh
from img_recog.simulation.settings import SimulationError

_MAX_BYTES = 1 << 28            # 5 million triangles of a binary STL
_STL_HEADER = 84                # bytes; it ends with the number of triangles
_TRIANGLE = np.dtype([('normal', '<f4', 3), ('vertices', '<f4', 9), ('attributes', '<u2')])
_MAX_NUMBER = float(np.finfo(np.float32).max)


def check(path: str) -> None:
    """Raise SimulationError unless a mesh file is complete and not too large."""
    advice = 'give a complete DAE, OBJ or binary STL file'
    try:
        size = os.path.getsize(path)
        if size > _MAX_BYTES:
            advice = 'give one with fewer triangles'
            raise DamagedMesh('it has {} bytes, more than {}'.format(size, _MAX_BYTES))
        _CHECKS.get(os.path.splitext(path)[1].lower(), lambda path: None)(path)
    except (OSError, ValueError, expat.ExpatError, DamagedMesh) as error:
        raise SimulationError('cannot read the mesh {}: {}'.format(path, one_line(error)), advice)


def _check_stl(path: str) -> None:
    with open(path, 'rb') as file:
        content = file.read()
    count = 0
    if len(content) >= _STL_HEADER:
        count, = struct.unpack_from('<I', content, _STL_HEADER - 4)
    expected = _STL_HEADER + _TRIANGLE.itemsize * count
    if len(content) != expected:
        raise DamagedMesh('it is an ASCII STL, and PyBullet reads binary ones'
                          if content.lstrip().startswith(b'solid') else
                          'it has {} bytes, expected {} for {} triangles'.format(
                              len(content), expected, count))
    triangles = np.frombuffer(content, _TRIANGLE, offset=_STL_HEADER)
    if not np.all(np.isfinite(triangles['vertices'])):
        raise DamagedMesh('a coordinate of a vertex is not a finite number')


def _check_obj(path: str) -> None:
    count = highest = 0
    with open(path, 'rb') as file:
        for line in file:
            words = line.split()
            if words[:1] == [b'v']:
                count += 1
                if len(words) < 4 or not all(abs(float(word)) <= _MAX_NUMBER
                                             for word in words[1:4]):
                    raise DamagedMesh('vertex {} does not have 3 finite coordinates'.format(
                        count))
            elif words[:1] == [b'f']:
                indices = [int(word.split(b'/')[0]) for word in words[1:]]
                if min(indices, default=1) < -count:    # counted backward from here
                    raise DamagedMesh('a face refers to vertex {} of {}'.format(
                        min(indices), count))
                if 0 in indices:
                    raise DamagedMesh('a face refers to vertex 0, the first is 1')
                highest = max([highest] + [abs(index) for index in indices])
    if not 0 < highest <= count:
        raise DamagedMesh('a face refers to vertex {} of {}'.format(highest, count) if highest
                          else 'it has no face')


_CHECKS = {'.stl': _check_stl, '.obj': _check_obj, '.dae': dae_check.check}
