"""The heightmaps of an SDF: terrain whose heights are the pixels of an image, or a DEM."""
import contextlib
import functools
import io
import math
import os
import re
import xml.etree.ElementTree as ElementTree
from typing import Iterator, NamedTuple, Optional, Tuple

import cv2
import numpy as np

from img_recog.errors import SimulationError, one_line
from img_recog.files import FindFile, no_file, plain
from img_recog.formats import generated_meshes
from img_recog.formats.reader import text_of, value
from img_recog.formats.still_images import pillow
from img_recog.model import HEIGHTMAP, Material, Shape
from img_recog.rotations import IDENTITY, Transform

FORMATS = 'GeoTIFF, Arc/Info ASCII grid (.asc) or SRTM (.hgt)'
_EARTH_RADIUS_M = 6371000.0     # of Gazebo's SphericalCoordinates
_NO_DATA = -9999.0              # heights up to this are unknown if the file names no other one
# tags of a TIFF: its size, and those of GeoTIFF and of GDAL
_WIDTH, _HEIGHT, _SCALE, _TIE, _KEYS, _GDAL_NO_DATA = 256, 257, 33550, 33922, 34735, 42113
_MATRIX = 34264                 # from pixels to places, instead of a scale and a tie point
_IN_DEGREES = 1024, 2           # a key of GeoTIFF and its value

# heights (rows, columns) in m, the first row is in the north; size of a cell in x and y;
# latitude of the upper edge if that size is in degrees, None if in m; largest unknown height
_Grid = Tuple[np.ndarray, Tuple[float, float], Optional[float], float]
_MAX_PIXELS = 50_000_000
# points on a side: where samples between pixels are left out; of the terrain; of what is drawn
_MAX_SAMPLED, _MAX_POINTS, _MAX_DRAWN = 513, 1025, 257
_EARTH = (0.42, 0.4, 0.32, 1.0)         # the color without a texture


class Elevations(NamedTuple):
    """The heights of a terrain.

    points: (n, n) in m, NaN where there are none. size: of the ground in m, and from the lowest
    known height to the highest one.
    """

    points: np.ndarray
    lowest: float
    size: Tuple[float, float, float]


def read_dem(path: str, max_heights: int) -> Optional[Elevations]:
    """Return the heights in a file, None if it is not a DEM.

    They are a square of 2^n + 1 points on a side, as in Dem::LoadData of Gazebo 11: the longer
    side is scaled to it, and the points that are left are 0. Raises an error of any type if the
    file is damaged, or is a TIFF of more than that many heights.
    """
    with open(path, 'rb', opener=plain) as file:
        content = file.read()
    grid = (_tiff(content, max_heights) if content[:2] in (b'II', b'MM') else
            _tile(path, content) if path.lower().endswith('.hgt') else
            _ascii_grid(path, content) if content[:5].lower() == b'ncols' else None)
    if grid is None:
        return None
    heights, step, north, no_data = grid
    longest = max(heights.shape)
    side = 1 + (1 << (longest - 2).bit_length())
    rows, columns = (
        ((np.arange(int(side * count / longest)) + 0.5) * longest / side).astype(int)
        for count in heights.shape)
    points = np.zeros((side, side))
    points[:len(rows), :len(columns)] = heights[np.ix_(rows, columns)]
    points[~np.isfinite(points)] = np.nan
    known = points[points > no_data]
    if not known.size:
        raise ValueError('it has no height above {:g}'.format(no_data))
    width, depth = heights.shape[1] * step[0], heights.shape[0] * step[1]
    if north is not None:
        half = math.cos(math.radians(north)) * math.sin(math.radians(width) / 2)
        width = 2 * _EARTH_RADIUS_M * math.asin(half)
        depth = _EARTH_RADIUS_M * math.radians(depth)
    return Elevations(points, float(known.min()), (width, depth, float(np.ptp(known))))


def _tiff(content: bytes, max_heights: int) -> Optional[_Grid]:
    """Return a GeoTIFF, None for another TIFF."""
    from PIL import TiffImagePlugin     # takes time, and few worlds have one
    file = io.BytesIO(content)
    tags = TiffImagePlugin.ImageFileDirectory_v2(file.read(16 if b'+' in content[2:4] else 8))
    file.seek(tags.next)
    tags.load(file)
    if _SCALE in tags:
        step, north = tags[_SCALE][:2], tags[_TIE][4] if _TIE in tags else 0.0
    elif _MATRIX in tags:
        x_x, x_y, _, _, y_x, y_y, _, north = tags[_MATRIX][:8]
        step = math.hypot(x_x, y_x), math.hypot(x_y, y_y)
    else:
        return None
    if tags[_WIDTH] * tags[_HEIGHT] > max_heights:
        raise ValueError('it has more than {} heights'.format(max_heights))
    heights = cv2.imdecode(np.frombuffer(content, np.uint8), cv2.IMREAD_UNCHANGED)
    if heights is None or heights.ndim != 2:
        raise ValueError('it does not have one band of a type that OpenCV reads')
    keys = tags.get(_KEYS, ())
    return (heights, step, north if _IN_DEGREES in zip(keys[::4], keys[3::4]) else None,
            float(tags.get(_GDAL_NO_DATA, _NO_DATA)))


def _tile(path: str, content: bytes) -> _Grid:
    """Return a tile of SRTM; its south-west corner is in its name."""
    name = re.match('([NS])([0-9]{2})[EW][0-9]{3}', os.path.basename(path).upper())
    side = math.isqrt(len(content) // 2)
    if name is None or side < 2 or len(content) != 2 * side * side:
        raise ValueError('it is not a square of 16-bit numbers with a name like N45E010.hgt')
    return (np.frombuffer(content, '>i2').reshape(side, side), (1 / (side - 1), 1 / (side - 1)),
            int(name.group(2)) + (1 if name.group(1) == 'N' else -1), -32768.0)


def _ascii_grid(path: str, content: bytes) -> _Grid:
    """Return an ASCII grid of Arc/Info; a file .prj beside it says whether it is in degrees."""
    words = content.lower().split()
    count = 2 * sum(word[:1].isalpha() for word in words[:14:2])
    header = dict(zip(words[:count:2], map(float, words[1:count:2])))
    step_x, step_y = (header.get(key, header.get(b'cellsize', 1.0)) for key in (b'dx', b'dy'))
    heights = np.array(words[count:], float).reshape(int(header[b'nrows']), int(header[b'ncols']))
    projection = os.path.splitext(path)[0] + '.prj'
    north = None
    if os.path.isfile(projection):
        with open(projection, 'rb') as file:
            if re.match(rb'\s*(Projection\s+)?GEOG', file.read(), re.IGNORECASE):
                south = header.get(b'yllcorner', header.get(b'yllcenter', 0.0))
                north = south + len(heights) * step_y
    return heights, (step_x, step_y), north, header.get(b'nodata_value', _NO_DATA)


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
            found = read_dem(path, _MAX_PIXELS)
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
        found = read_dem(path, _MAX_PIXELS)
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
    with open(path, 'rb', opener=plain) as file, pillow().open(file) as image:
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
            'give a PNG or JPEG file, or a DEM as ' + FORMATS
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
