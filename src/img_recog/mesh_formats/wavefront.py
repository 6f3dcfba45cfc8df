"""OBJ files of Wavefront, and their files of materials."""
import contextlib
import os
import re
from typing import Any, Dict, List, Mapping, Optional, Sequence, Tuple

import numpy as np

from img_recog.mesh_formats.file_material import FileMaterial, find_texture
from img_recog.mesh_formats.polygons import FilePart, fans

_LIBRARY = re.compile(rb'^[ \t]*mtllib[ \t]+(.*?)[ \t]*\r?$', re.MULTILINE)
_CONTINUED = re.compile(rb'\\\r?\n')        # a line that goes on in the next one
_WRONG = 'a face refers to vertex {} of {}, the first is 1'
_MAX_BYTES = 1 << 24
_OPTIONS = re.compile(r'(?:-[a-z]+(?:\s+(?:on|off|[-+.\d]+(?=\s)))*\s+)*', re.IGNORECASE)


def read(content: bytes, mesh: str) -> List[FilePart]:
    """Return the triangles of an OBJ; mesh: its path.

    The name of a part is that of the object or group before it, like in Gazebo. Raises an error of
    any type if it cannot be read.
    """
    materials: Dict[str, FileMaterial] = {}
    for file in libraries(content, mesh):
        materials.update(read_mtl(_text(file), mesh))
    values: Dict[str, List[List[str]]] = {'v': [], 'vt': [], 'vn': []}
    name, material = '', None       # type: Tuple[str, Optional[FileMaterial]]
    sizes: List[int] = []           # how many corners each face of a part has
    corners: List[str] = []         # of these faces, like 1/2/3
    faces = {(name, material): (sizes, corners)}
    for line in _CONTINUED.sub(b' ', content).decode('utf-8', 'replace').splitlines():
        words = line.split()
        key = words[0] if words else ''
        if key in values:
            values[key].append(words[1:])
        elif key == 'f':
            sizes.append(len(words) - 1)
            corners += words[1:] if '-' not in line else [
                _absolute(word, values) for word in words[1:]]
        elif key in ('o', 'g', 'usemtl'):
            rest = ' '.join(words[1:])
            name, material = (name, materials.get(rest)) if key == 'usemtl' else (rest, material)
            sizes, corners = faces.setdefault((name, material), ([], []))
    # the first row, of zeros, is for corners without a texture coordinate or a normal
    tables = [np.array([['0'] * count, *((row + ['0'])[:count] for row in values[key])], float)
              for key, count in (('v', 3), ('vt', 2), ('vn', 3))]
    parts = []
    for (name, material), (sizes, corners) in faces.items():
        indices = _indices(corners, len(values['v']))[fans(np.array(sizes, int))]
        for column in (1, 2):       # texture coordinates and normals that do not exist
            indices[..., column] *= indices[..., column] < len(tables[column])
        positions, uvs, normals = (table[indices[..., column]]
                                   for column, table in enumerate(tables))
        parts.append(FilePart(positions, normals, uvs, material, name))
    return parts


def _indices(corners: List[str], count: int) -> np.ndarray:
    """Return the indices (n, 3) of corners, 0 for those that one has not; count: of vertices."""
    rows = np.zeros((len(corners), 3), int)
    width = corners[0].count('/') + 1 if corners else 1
    text = ' '.join(corners)
    numbers = np.array(text.replace('/', ' ').split(), int)
    if width <= 3 and len(numbers) == width * len(corners) and all(
            corner.count('/') == width - 1 for corner in corners):
        rows[:, :width] = numbers.reshape(-1, width)
    else:
        for row, corner in zip(rows, corners):
            words = corner.split('/')[:3]
            row[:len(words)] = [int(word or 0) for word in words]
    if len(rows) and rows[:, 0].min() < 1:
        raise ValueError(_WRONG.format(rows[:, 0].min(), count))
    return rows


def _absolute(corner: str, values: Mapping[str, Sequence[Any]]) -> str:
    """Return a corner whose indices count from 1; they may count backward from the last, -1.

    values: what they count, as far as it has been read.

    >>> _absolute('-1//3', {'v': range(8), 'vt': (), 'vn': range(4)})
    '8//3'
    """
    words = []
    for word, rows in zip(corner.split('/'), values.values()):
        number = int(word or 0)
        if number < -len(rows):
            raise ValueError(_WRONG.format(number, len(rows)))
        words.append(str(number + len(rows) + 1) if number < 0 else word)
    return '/'.join(words)


def libraries(content: bytes, mesh: str) -> List[str]:
    """Return the paths of the files of materials that an OBJ names; mesh: its path."""
    return [name for line in _LIBRARY.findall(content)
            for name in _library_names(line.decode('utf-8', 'replace'), mesh)]


def _library_names(line: str, mesh: str) -> List[str]:
    """Return the paths of the files of materials that a line names: one, or several."""
    folder = os.path.dirname(os.path.abspath(mesh))
    whole = os.path.join(folder, line)
    return [whole] if os.path.isfile(whole) else [
        os.path.join(folder, name) for name in line.split()]


def _text(path: str) -> str:
    """Return the content of a file of materials, '' if there is none, like in Gazebo."""
    try:
        with open(path, 'rb') as file:
            return file.read(_MAX_BYTES).decode('utf-8', 'replace')
    except OSError:
        return ''


def read_mtl(text: str, mesh: str) -> Dict[str, FileMaterial]:
    """Return the materials of an OBJ's material file by name; mesh: the path of the OBJ."""
    found: Dict[str, FileMaterial] = {}
    name: Optional[str] = None
    for line in text.splitlines():
        words = line.split(None, 1)
        if len(words) < 2:
            continue
        key, value = words[0].lower(), words[1].strip()
        if key == 'newmtl':
            name = ' '.join(value.split())
            found[name] = FileMaterial()
        elif name is not None:
            with contextlib.suppress(ValueError, IndexError):       # like Gazebo
                found[name] = _with_property(found[name], key, value, mesh)
    return found


def _with_property(material: FileMaterial, key: str, value: str, mesh: str) -> FileMaterial:
    """Return a material with a property of a material file; ValueError for a wrong number."""
    red, green, blue, opacity = material.color
    if key == 'kd' and value[:1] not in ('s', 'x'):        # spectral and CIEXYZ: not in use
        red, green, blue = (float(word) for word in (value.split() * 3)[:3])
    elif key == 'd':
        opacity = float(value.split()[-1])
    elif key == 'tr':
        opacity = 1.0 - float(value.split()[-1])
    elif key == 'map_kd':
        return material._replace(texture=find_texture(mesh, _OPTIONS.sub('', value, count=1)))
    return material._replace(color=(red, green, blue, min(max(opacity, 0.0), 1.0)))


def written(parts: Sequence[np.ndarray], library: str = '') -> str:
    """Return an OBJ with an object for each part.

    parts: the coordinates (n, 3, 3) of the corners of triangles, or with uvs (n, 3, 5). library:
    the name of the file of materials, in which each part has its number as the name.
    """
    lines, count = ['mtllib ' + library] if library else [], 1
    for number, part in enumerate(parts):
        corners, indices = np.unique(part.reshape(-1, part.shape[2]), axis=0, return_inverse=True)
        has_uvs = part.shape[2] > 3
        lines.append('o {0}\nusemtl {0}'.format(number) if library else 'o {}'.format(number))
        row = 'v %.9g %.9g %.9g' + has_uvs * '\nvt %.9g %.9g'
        lines += [row % tuple(corner) for corner in corners.tolist()]
        face = 'f {0}/{0} {1}/{1} {2}/{2}' if has_uvs else 'f {} {} {}'
        lines += [face.format(*corner) for corner in (indices.reshape(-1, 3) + count).tolist()]
        count += len(corners)
    return '\n'.join(lines) + '\n'
