"""Digital elevation models (DEM): files of measured heights, read as Gazebo 11 does with GDAL."""
import io
import math
import os
import re
from typing import NamedTuple, Optional, Tuple

import cv2
import numpy as np

from img_recog.files import plain

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


class Elevations(NamedTuple):
    """The heights of a terrain.

    points: (n, n) in m, NaN where there are none. size: of the ground in m, and from the lowest
    known height to the highest one.
    """

    points: np.ndarray
    lowest: float
    size: Tuple[float, float, float]


def read(path: str, max_heights: int) -> Optional[Elevations]:
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
