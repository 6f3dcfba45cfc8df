"""The heightmaps of an SDF: terrain whose heights are the pixels of an image, or a DEM."""
import contextlib
import functools
import os
import xml.etree.ElementTree as ElementTree
from typing import Iterator, NamedTuple, Tuple

import numpy as np

from img_recog.errors import SimulationError, one_line
from img_recog.files import FindFile, no_file, plain
from img_recog.formats import elevations, generated_meshes
from img_recog.formats.reader import text_of, value
from img_recog.model import HEIGHTMAP, Material, Shape
from img_recog.rotations import IDENTITY, Transform

_MAX_PIXELS = 50_000_000
# points on a side: where samples between pixels are left out; of the terrain; of what is drawn
_MAX_SAMPLED, _MAX_POINTS, _MAX_DRAWN = 513, 1025, 257
_EARTH = (0.42, 0.4, 0.32, 1.0)         # the color without a texture


class Heightmap(NamedTuple):
    """heights (rows, columns): m, the first row is that with the smallest y; size: x, y in m."""

    heights: np.ndarray
    size: Tuple[float, float]

    @property
    def middle(self) -> float:
        """The height in the middle between the lowest and the highest point."""
        return float(self.heights.min() + self.heights.max()) / 2


def shape(name: str, element: ElementTree.Element, find: FindFile) -> Tuple[Shape, Transform]:
    """Return a <heightmap>, and its pose in the frame of the <visual> or <collision>.

    name: of that. Raises SimulationError when it cannot be used.
    """
    uri = text_of(element, 'uri')
    path = find(uri)
    if path is None or not os.path.isfile(path):
        raise SimulationError('heightmap ' + uri + no_file(path))
    size = _size(name, element, path)
    if not (size[:2] > 0).all():
        raise SimulationError('<size> of {}: got {!r}, expected more than 0'.format(
            name, element.findtext('size')))
    sampling = max(value(element, 'sampling', name), 1)
    made = Shape(HEIGHTMAP, (*size.tolist(), sampling), os.path.abspath(path))
    read(made)
    return made, IDENTITY._replace(translation=value(element, 'pos', name))


def _size(name: str, element: ElementTree.Element, path: str) -> np.ndarray:
    """Return the <size> of a heightmap; without one, that of the ground of a DEM."""
    if element.find('size') is None:
        with _refused(path):
            found = elevations.read(path, _MAX_PIXELS)
        if found is not None:
            return np.array(found.size)
    return value(element, 'size', name)


def read(shape: Shape) -> Heightmap:
    """Return the heights of a HEIGHTMAP.

    As in Gazebo 11 (ImageHeightmap::FillHeightMap), the upper row of the image has the largest y,
    white the height <size> z if a pixel has the value 1, else the brightest pixel, and <sampling>
    - 1 points stand between two pixels. Where that gives more than 513 points on a side, there are
    none; more than 1025 pixels are reduced. A DEM begins at its lowest height, and <size> z is
    the height of the highest point above that (Dem::FillHeightMap).
    Raises SimulationError when the file cannot be read.
    """
    try:
        changed_ns = os.stat(shape.path).st_mtime_ns
    except OSError:
        changed_ns = 0      # what cannot be read has its error below
    return _heightmap(shape.path, changed_ns, *shape.size)


@functools.lru_cache(maxsize=1)     # what is driven on is drawn too, and both are checked before
def _heightmap(path: str, _: int, width: float, depth: float, top: float,
               sampling: int) -> Heightmap:
    """Return the heightmap of a file; the time of its last change makes another one of it."""
    with _refused(path):
        found = elevations.read(path, _MAX_PIXELS)
        pixels, brightest = _pixels(path) if found is None else (found.points, found.size[2])
    lowest = 0.0 if found is None else found.lowest
    rows, columns = (_coordinates(count, sampling) for count in pixels.shape)
    heights = lowest + (_interpolated(pixels, rows, columns) - lowest) * abs(top) / (
        brightest or 1.0)
    if found is not None:
        heights[np.isnan(heights)] = lowest
        heights = np.maximum(heights, lowest) if top >= 0 else -heights
    elif top < 0:
        heights = 1.0 - heights     # Gazebo does so
    heights = np.ascontiguousarray(heights[::-1])
    heights.flags.writeable = False
    return Heightmap(heights, (width, depth))


def write_mesh(shape: Shape) -> str:
    """Write a mesh to draw a HEIGHTMAP; return the path.

    Its texture coordinates are 0 to 1 over the whole. Raises SimulationError like `read`.
    """
    heightmap = read(shape)
    rows, columns = (np.linspace(0, count - 1, min(count, _MAX_DRAWN))
                     for count in heightmap.heights.shape)
    heights = _interpolated(heightmap.heights, rows, columns)
    v, u = np.meshgrid(rows / rows[-1], columns / columns[-1], indexing='ij')
    width, depth = heightmap.size
    vertices = np.stack([(u - 0.5) * width, (v - 0.5) * depth, heights], axis=-1).reshape(-1, 3)
    return generated_meshes.write(vertices, generated_meshes.grid_faces(len(rows), len(columns)),
                                  np.stack([u, v], axis=-1).reshape(-1, 2))


def material(element: ElementTree.Element, find: FindFile) -> Material:
    """Return what a heightmap of an SDF looks like: its first texture, else the color of earth."""
    size = value(element, 'size')
    texture = element.find('texture')
    path = None if texture is None else find(text_of(texture, 'diffuse'))
    if texture is None or path is None or not os.path.isfile(path):
        return Material(_EARTH)
    width, depth = (float(value(element, 'texture/size') / each) or 1.0 for each in size[:2])
    return Material((1.0, 1.0, 1.0, 1.0), os.path.abspath(path), (width, depth))


def _pixels(path: str) -> Tuple[np.ndarray, float]:
    """Return the pixels of an image, (rows, columns), and the value that has the whole height.

    Of colors, blue counts, and the value is that of the brightest color; Gazebo takes a 1 in it
    for white. Of 16 bits, which Gazebo reads wrongly, white has the whole height.
    """
    from PIL import Image       # takes time, and few worlds have one
    with open(path, 'rb', opener=plain) as file, Image.open(file) as image:
        if image.width * image.height > _MAX_PIXELS or min(image.size) < 2:
            raise ValueError('{}x{} pixels, expected 2 to {} in all, on a side 2 or more'
                             .format(image.width, image.height, _MAX_PIXELS))
        if image.mode in ('I', 'I;16', 'I;16B'):
            return np.array(image, float), 65535.0
        colors = np.array(image.convert('RGB')).reshape(-1, 3)
        pixels = colors[:, 2].reshape(image.height, image.width).astype(float)
        colors[colors == 1] = 255
        return pixels, float(colors[colors.sum(axis=1, dtype=np.uint16).argmax(), 2])


@contextlib.contextmanager
def _refused(path: str) -> Iterator[None]:
    """Raise SimulationError for any error that Pillow and OpenCV have with a file."""
    try:
        yield
    except Exception as error:
        reason = ('its format is not supported' if type(error).__name__ == 'UnidentifiedImageError'
                  else one_line(error))
        raise SimulationError('heightmap {}: {}'.format(path, reason), (
            'give a PNG or JPEG file, or a DEM as ' + elevations.FORMATS
            + '; gdal_translate of GDAL converts others'))


def _coordinates(pixels: int, sampling: int) -> np.ndarray:
    """Return where the points of a side are, in pixels."""
    points = (pixels - 1) * sampling + 1
    if points > _MAX_SAMPLED:
        points = min(pixels, _MAX_POINTS)
    return np.linspace(0, pixels - 1, points)


def _interpolated(values: np.ndarray, rows: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Return values (n, m) between their rows and columns, bilinearly."""
    for axis, at in ((0, rows), (1, columns)):
        first = np.floor(at).astype(int)
        second = np.minimum(first + 1, values.shape[axis] - 1)
        weight = np.expand_dims(at - first, 1 - axis)
        values = (np.take(values, first, axis) * (1 - weight)
                  + np.take(values, second, axis) * weight)
    return values
