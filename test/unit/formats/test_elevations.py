"""Digital elevation models: the heights that Gazebo 11 makes of them, and files that are refused.

The expected values are distances that rays of Gazebo measured down from z = 30 m.
"""
import xml.etree.ElementTree as ElementTree

import cv2
import numpy as np
import pytest
from PIL import Image, TiffImagePlugin

from img_recog.formats import heightmaps
from img_recog_helpers.refusals import refusal

POINTS = [(0, 0), (5, 5), (-5, 5), (5, -5), (-8, 0), (8, 2)]
OF_GAZEBO = [25.934, 26.762, 26.158, 24.045, 27.977, 25.604]
SIZE = '<size>20 20 5</size>'
PROJECTION = 'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563]]]'


def hills(columns=33, rows=33, lowest=1.2, highest=3.2):
    y, x = np.mgrid[:rows, :columns].astype(float)
    heights = np.sin(x / columns * 7) * np.cos(y / rows * 5) + x / columns * 0.8 + 0.3 * y / rows
    heights = (heights - heights.min()) / np.ptp(heights)
    return (lowest + heights * (highest - lowest)).astype(np.float32)


def with_a_gap(value):
    heights = hills()
    heights[10:14] = value
    return heights


def geotiff(folder, heights, no_data='', geographic=True, has_matrix=False, **options):
    """Write a GeoTIFF whose cells are 1e-5 degrees or 1 m; return its path.

    has_matrix: Whether a matrix says where the cells are, instead of a scale and a tie point.
    """
    tags = TiffImagePlugin.ImageFileDirectory_v2()
    step = 1e-5 if geographic else 1.0
    matrix = (step, 0, 0, 10.0, 0, -step, 0, 45.0, 0, 0, 0, 0, 0, 0, 0, 1)
    places = ((34264, 12, tuple(map(float, matrix))),) if has_matrix else (
        (33550, 12, (step, step, 0.0)), (33922, 12, (0, 0, 0, 10.0, 45.0, 0)))
    for tag, kind, value in (*places, (34735, 3, (1, 1, 0, 1, 1024, 0, 1, 2 if geographic else 1)),
                             (42113, 2, no_data)):
        if value:
            tags.tagtype[tag] = kind
            tags[tag] = value
    Image.fromarray(heights).save(str(folder / 'a.tif'), tiffinfo=tags, **options)
    return str(folder / 'a.tif')


def ascii_grid(folder, heights, header='cellsize 1e-5\nNODATA_value -9999\n'):
    (folder / 'a.prj').write_text(PROJECTION)
    rows = '\n'.join(' '.join(map(repr, row.tolist())) for row in heights)
    size = 'ncols {1}\nnrows {0}\nxllcorner 10\nyllcorner 44.99967\n'.format(*heights.shape)
    (folder / 'a.asc').write_text(size + header + rows)
    return str(folder / 'a.asc')


def tile(folder, heights):
    (folder / 'n45e010.hgt').write_bytes(np.rint(heights).astype('>i2').tobytes())
    return str(folder / 'n45e010.hgt')


def shape(path, inside):
    element = ElementTree.fromstring('<heightmap><uri>a</uri>{}</heightmap>'.format(inside))
    return heightmaps.shape('a', element, lambda uri: path)[0]


def distances(path, inside=SIZE):
    """Return what rays measure at POINTS."""
    found = heightmaps.read(shape(path, inside))
    (x, y), (rows, columns) = np.transpose(POINTS), found.heights.shape
    x, y = (x / found.size[0] + 0.5) * (columns - 1), (y / found.size[1] + 0.5) * (rows - 1)
    return 30 - cv2.remap(found.heights, np.float32([x]), np.float32([y]), cv2.INTER_LINEAR)[0]


@pytest.mark.parametrize('heights, inside, expected', [
    (hills(), SIZE, OF_GAZEBO),
    (hills(), '<size>20 20 -5</size>', [34.066, 33.238, 33.842, 35.955, 32.023, 34.396]),
    (hills(), '<size>20 20 0</size>', [28.8] * 6),
    (hills(), '', [27.653, 27.559, 28.112, 26.816, 28.624, 27.290]),
    (hills(lowest=-2, highest=3), SIZE, [29.134, 29.962, 29.358, 27.245, 31.177, 28.804]),
    (hills(lowest=-5, highest=-2), '', [33.280, 33.138, 33.968, 32.024, 34.736, 32.735]),
    (hills(lowest=-1, highest=0), SIZE, [28.134, 28.962, 28.358, 26.245, 30.177, 27.804]),
    (np.full((33, 33), np.float32(2)), SIZE, [28.0] * 6),
    (hills(20, 20), SIZE, [25.702, 26.771, 26.221, 23.888, 28.062, 25.520]),
    (hills(40, 20), SIZE, [30.000, 25.334, 27.865, 30.000, 30.000, 25.987]),
    (hills(20, 40), SIZE, [30.000, 30.000, 26.803, 30.000, 27.916, 30.000]),
    (with_a_gap(-9999), SIZE, OF_GAZEBO[:5] + [28.8]),
    (with_a_gap(np.nan), SIZE, OF_GAZEBO[:5] + [28.8])])
def test_heights_are_those_of_gazebo(tmp_path, heights, inside, expected):
    assert distances(geotiff(tmp_path, heights), inside) == pytest.approx(expected, abs=5e-3)


@pytest.mark.parametrize('write, expected', [
    (lambda folder: geotiff(folder, hills(), compression='tiff_lzw'), OF_GAZEBO),
    (lambda folder: geotiff(folder, hills(), has_matrix=True), OF_GAZEBO),
    (lambda folder: geotiff(folder, with_a_gap(-100), '-100'),
     OF_GAZEBO[:5] + [28.8]),
    (lambda folder: geotiff(folder, np.rint(hills(lowest=10, highest=200)).astype(
        np.uint8)),
     [17.132, 17.974, 17.368, 15.237, 19.174, 16.805]),
    (lambda folder: ascii_grid(folder, hills()), OF_GAZEBO),
    (lambda folder: tile(folder, hills(1201, 1201, 0, 900)),
     [26.911, 27.806, 27.417, 25.428, 29.249, 26.896])])
def test_kinds_of_files(tmp_path, write, expected):
    assert distances(write(tmp_path)) == pytest.approx(expected, abs=5e-3)


@pytest.mark.parametrize('write, width, depth', [
    (lambda folder: geotiff(folder, hills()), 25.95, 36.69),
    (lambda folder: geotiff(folder, hills(), has_matrix=True), 25.95, 36.69),
    (lambda folder: geotiff(folder, hills(), geographic=False), 33, 33),
    (lambda folder: geotiff(folder, hills(), geographic=False, has_matrix=True), 33, 33),
    (lambda folder: ascii_grid(folder, hills(), 'dx 1e-5\ndy 2e-5\n'), 25.95, 73.39),
    (lambda folder: tile(folder, hills(1201, 1201)), 77304, 111288)])
def test_size_of_the_ground(tmp_path, write, width, depth):
    assert shape(write(tmp_path), '').size[:2] == pytest.approx((width, depth), rel=1e-3)


def test_a_tiff_of_floats_without_a_place_on_earth_is_an_image(tmp_path):
    Image.fromarray(hills()).save(str(tmp_path / 'a.tif'))
    assert heightmaps.read_dem(str(tmp_path / 'a.tif'), 10000) is None


@pytest.mark.parametrize('name, content, words', [
    ('a.dem', b'USGS', 'its format is not supported; give a PNG or JPEG file, or a DEM as '),
    ('a.hgt', b'\0' * 8, 'a name like N45E010.hgt'), ('n45e010.hgt', b'\0' * 7, '16-bit'),
    ('a.asc', b'ncols 2\nnrows 2\n1 2 3', 'reshape'), ('a.asc', b'NCOLS', "b'nrows'"),
    ('a.tif', b'II*\0', '')])
def test_what_cannot_be_read_has_one_line(tmp_path, name, content, words):
    path = str(tmp_path / name)
    (tmp_path / name).write_bytes(content)
    for inside in (SIZE, ''):
        line = refusal(shape, path, inside)
        assert line.startswith('heightmap {}: '.format(path)) and words in line, line


@pytest.mark.parametrize('heights, no_data, words', [
    (hills(), '5', 'it has no height above 5'),
    (np.zeros((8000, 8000), np.uint8), '', 'more than'),
    (np.zeros((2, 2, 3), np.uint8), '', 'one band')])
def test_geotiffs_that_are_refused(tmp_path, heights, no_data, words):
    assert words in refusal(shape, geotiff(tmp_path, heights, no_data), SIZE)
