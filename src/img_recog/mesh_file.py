"""Reads mesh files (DAE, OBJ, STL) by trimesh, which is only loaded when there is one to read.

The image of a simulated camera and the physics use the same reader. PyBullet's own ones follow
the indices in a damaged file without a check, and ignore triangles that stand behind a comment.
"""
import io
import logging
import os
import re
from typing import Any, Dict, List, NamedTuple, Optional
from urllib.parse import unquote

import numpy as np

from img_recog.errors import UserError, one_line
from img_recog.visuals import GREY, Color

READABLE = ('.dae', '.obj', '.stl')
# a triangle takes 300 bytes while it is read, and 108 when it is drawn
_MAX_BYTES, MAX_TRIANGLES = 1 << 28, 3_000_000
_MAX_POSITION = 1e9
_MAX_SHAPES = 10_000            # that the nodes of a COLLADA file refer to
# where Gazebo looks for the textures of a mesh
_FOLDERS = ('', os.path.join('..', 'materials', 'textures'))
_FILE = 'file://'
_MATERIALS = '.mtl'     # of Wavefront's OBJ, not an image
# lines of an OBJ that trimesh misreads: with a tab or a space first, or with an index up to 0
_UNUSUAL = re.compile(rb'^[ \t]|^[vf][nt]?\t|^f.*[ \t/](-|0([/\s]|$))', re.MULTILINE)
_COMMENT = re.compile(b'<!--.*?-->', re.DOTALL)     # pycollada gives up at one within a <mesh>
_KINDS = ('v', 'vt', 'vn')      # what the indices of a corner of a face count


class Triangles(NamedTuple):
    """Triangles of one material.

    positions (n, 3, 3): in m, a row a corner; normals (n, 3, 3): unit vectors; uvs (n, 3, 2): from
    the lower left corner of the texture; color: of the material; texture (rows, columns, 3): RGB,
    uint8, or None; has_material: whether the file states the color or texture; problem: what of
    the file cannot be read, else ''.
    """

    positions: np.ndarray
    normals: np.ndarray
    uvs: np.ndarray
    color: Color = GREY
    texture: Optional[np.ndarray] = None
    has_material: bool = False
    problem: str = ''


class MeshError(UserError):
    """A mesh file cannot be read."""


def read(path: str) -> List[Triangles]:
    """Return the triangles of a mesh file, in m, in the axes that the file uses.

    Like in Gazebo, the unit that a COLLADA file states counts, and its <up_axis> does not.
    Raises MeshError naming the file.
    """
    images = _Images(path)
    triangles = [_triangles(part, images) for part in _parts(path, images)]
    if images.problems:
        triangles[0] = triangles[0]._replace(problem='cannot read all of the mesh {}: {}'.format(
            path, ', '.join(images.problems)))
    return triangles


def write(path: str, folder: str, materials: bool = False) -> str:
    """Write the shapes of a mesh file, in m, as a file that PyBullet can read; return its path.

    That is an OBJ for an OBJ, whose objects get a convex hull each, and else a binary STL.
    materials: whether to write those of an OBJ beside it.
    Raises MeshError naming the file that cannot be read.
    """
    import trimesh
    parts = _parts(path, _Images(path) if materials else _NoFiles())
    for number, part in enumerate(parts):
        if materials and hasattr(part.visual, 'material'):
            # PyBullet has room for names of 4096 characters
            part.visual.material.name = 'material_{}'.format(number)
        else:
            parts[number] = trimesh.Trimesh(part.vertices, part.faces, process=False)
    written = os.path.join(folder, 'mesh' + written_suffix(path))
    trimesh.Scene(parts).export(written)
    return written


def written_suffix(path: str) -> str:
    """Return how the name of the file ends that `write` writes for a mesh file.

    >>> written_suffix('house.DAE'), written_suffix('chair.obj')
    ('.stl', '.obj')
    """
    return '.obj' if _suffix(path) == '.obj' else '.stl'


def read_content(path: str) -> bytes:
    """Return the content of a mesh file; MeshError when it is too large or cannot be read."""
    try:
        size = os.path.getsize(path)
        if size > _MAX_BYTES:
            raise ValueError('it has {} bytes, more than {}'.format(size, _MAX_BYTES))
        with open(path, 'rb') as file:
            return file.read()
    except (OSError, ValueError) as error:
        raise _unreadable(path, error)


def _parts(path: str, images: Any) -> 'List[Any]':
    """Return the parts of a mesh file as trimesh.Trimesh in m; images: finds what it refers to."""
    content, suffix = read_content(path), _suffix(path)
    try:
        if suffix not in READABLE:
            raise ValueError('its name ends with {!r}, expected {}'.format(
                suffix, ', '.join(READABLE)))
        if suffix == '.dae':
            content = _COMMENT.sub(b'', content)
            _check_collada(content)
        if suffix == '.obj' and _UNUSUAL.search(content):
            content = _as_usual(content.decode('utf-8', 'replace')).encode()
        with np.errstate(invalid='ignore', over='ignore'):
            return _loaded(content, suffix, images)
    except Exception as error:      # the readers raise errors of many types
        raise _unreadable(path, error)


def _unreadable(path: str, error: Exception) -> MeshError:
    return MeshError('cannot read the mesh {}: {}'.format(path, one_line(error)),
                     'give a DAE, OBJ or STL file that is complete')


def _suffix(path: str) -> str:
    return os.path.splitext(path)[1].lower()


def _loaded(content: bytes, suffix: str, images: Any) -> 'List[Any]':
    import trimesh
    logging.getLogger('trimesh').propagate = False      # `_Images` tells what it cannot read
    options = {'split_objects': True, 'split_groups': True} if suffix == '.obj' else {}
    scene = trimesh.load_scene(io.BytesIO(content), file_type=suffix[1:], process=False,
                               resolver=images, **options)
    parts = [part for part in scene.dump() if isinstance(part, trimesh.Trimesh)
             and len(part.faces)]
    count = sum(len(part.faces) for part in parts)
    if not 0 < count <= MAX_TRIANGLES:
        raise ValueError('it has {} triangles, allowed are 1 to {}'.format(count, MAX_TRIANGLES))
    words = str(scene.units or '').split(' * ')     # as load_collada writes it
    unit = float(words[0]) if len(words) == 2 else 1.0
    if not unit > 0:
        raise ValueError('its unit has the length {:g}'.format(unit))
    for part in parts:
        # what is not a number is not less either
        if not np.abs(part.vertices).max() * unit < _MAX_POSITION:
            raise ValueError('it has a coordinate of more than {:g}'.format(_MAX_POSITION))
        if unit != 1:
            part.apply_scale(unit)
    return parts


def _check_collada(content: bytes) -> None:
    """Raise ValueError for what makes a small file so large that it cannot be read.

    That are entities within entities, which expat limits only from 2.4.0 on, and nodes that
    refer to nodes, which trimesh follows without an end.
    """
    if b'<!ENTITY' in content or b'\0' in content:
        raise ValueError('it has entities, or is not UTF-8')
    if b'instance_node' not in content and (
            content.count(b'instance_geometry') <= 2 * content.count(b'<geometry ')):
        return      # each geometry stands where it is
    import collada
    errors = [collada.common.DaeError, *collada.common.DaeError.__subclasses__()]
    scene = collada.Collada(io.BytesIO(content), ignore=errors).scene
    count = 0
    for number, bound in enumerate(scene.objects('geometry')):
        count += sum(map(len, bound.original.primitives))
        if number > _MAX_SHAPES or count > MAX_TRIANGLES:
            raise ValueError('it has more than {} shapes or {} triangles'.format(
                _MAX_SHAPES, MAX_TRIANGLES))


def _as_usual(text: str) -> str:
    """Return an OBJ in which all lines begin with a word, and all indices count from the first."""
    counts = dict.fromkeys(_KINDS, 0)
    lines = []
    for line in text.splitlines():
        words = line.split()
        if words and words[0] in counts:
            counts[words[0]] += 1
        if words and words[0] == 'f':
            words = ['f'] + ['/'.join(_absolute(index, counts[kind]) for kind, index in zip(
                _KINDS, corner.split('/'))) for corner in words[1:]]
        lines.append(' '.join(words))
    return '\n'.join(lines)


def _absolute(index: str, count: int) -> str:
    """Return an index that counts from 1; `index` may count backward from the last one, -1.

    >>> _absolute('-1', 8), _absolute('3', 8)
    ('8', '3')
    """
    number = int(index or 1)
    if not -count <= number or number == 0:
        raise ValueError('a face refers to vertex {} of {}, the first is 1'.format(number, count))
    return str(count + 1 + number) if number < 0 else index


def _triangles(mesh: Any, images: '_Images') -> Triangles:
    """Return what trimesh has read of one material."""
    positions = np.asarray(mesh.triangles, float)
    has_normals = 'vertex_normals' in mesh._cache       # not a getter, which would compute them
    normals = (mesh.vertex_normals[mesh.faces] if has_normals
               else np.repeat(mesh.face_normals[:, None], 3, axis=1))
    color, texture, uvs = GREY, None, np.zeros((len(positions), 3, 2))
    visual: Any = mesh.visual
    if visual.kind == 'texture':
        material = visual.material.to_simple() if hasattr(
            visual.material, 'to_simple') else visual.material
        color = _color(material.main_color)
        if visual.uv is not None:
            uvs = np.asarray(visual.uv)[mesh.faces]
            if material.image is not None:
                texture, color = images.decoded(material.image), (1.0, 1.0, 1.0, color[3])
    elif visual.kind is not None:
        color = _color(visual.main_color)
    return Triangles(positions, np.asarray(normals, float), uvs, color, texture,
                     visual.kind is not None)


def _color(values: Any) -> Color:
    """Return a color of 0 to 255 as one of 0 to 1."""
    red, green, blue, opacity = (float(value) / 255 for value in values)
    return red, green, blue, opacity


class _NoFiles:
    """Finds nothing that a mesh file refers to: for what needs its shapes alone."""

    def get(self, name: str) -> bytes:
        raise OSError('{} is not read'.format(name))

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)


class _Images(_NoFiles):
    """Finds and decodes what a mesh file refers to; trimesh does not tell what it cannot read.

    problems: a text for each of these.
    """

    def __init__(self, path: str):
        """path: of the mesh file."""
        self._folder = os.path.dirname(os.path.abspath(path))
        self.problems: List[str] = []
        self._decoded: Dict[int, np.ndarray] = {}

    def get(self, name: str) -> bytes:
        """Return the content of a file, which is found as Gazebo finds it.

        Raises an error, which trimesh ignores, if there is none or it is a damaged image.
        """
        from PIL import Image   # takes time, as `textures` does, and few meshes have images

        from img_recog import textures
        given = unquote(str(name))
        given = given[len(_FILE):] if given.startswith(_FILE) else given
        paths = (os.path.join(self._folder, folder, given) for folder in _FOLDERS)
        path = next((each for each in paths if os.path.isfile(each)), '')
        try:
            with open(path, 'rb') as file:
                content = file.read(_MAX_BYTES)
            if not given.lower().endswith(_MATERIALS):
                # trimesh copies images, which decodes them whatever they are
                with Image.open(io.BytesIO(content)) as image:
                    textures.decoded(image)
        except Exception as error:      # Pillow raises errors of many types
            text = 'its texture {}: {}'.format(given, one_line(error))
            self.problems += [] if text in self.problems else [text]
            raise
        return content

    def decoded(self, image: Any) -> np.ndarray:
        """Return the pixels of an image that trimesh has opened, RGB."""
        from img_recog import textures
        key = id(image)     # the material keeps it
        if key not in self._decoded:
            self._decoded[key] = textures.decoded(image)
        return self._decoded[key]
