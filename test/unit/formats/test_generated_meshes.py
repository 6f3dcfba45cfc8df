"""Meshes of outlines: closed, of the right volume, and seen from outside."""
import collections
import hashlib
import os
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from img_recog.formats import generated_meshes, sdf_links
from img_recog.formats.meshes import mesh_file
from img_recog.rotations import IDENTITY
from img_recog_helpers.refusals import refusal

# an L of 3 m2, anticlockwise
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
# a comb, whose ears lie between other corners, and a spiral
COMB = [(0, 0), (5, 0), (5, 2), (4, 2), (4, 1), (3, 1), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2),
        (0, 2)]
SPIRAL = [(0, 0), (4, 0), (4, 4), (1, 4), (1, 2), (2, 2), (2, 3), (3, 3), (3, 1), (0, 1)]


def volume(path):
    corners = np.concatenate([part.positions for part in mesh_file.read(path)])
    return np.einsum('ij,ij->i', corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6


@pytest.mark.parametrize('outline, area', [(L_SHAPE, 3), (COMB, 8), (SPIRAL, 10),
                                           ([(0, 0), (3, 0), (3, 4)], 6)])
@pytest.mark.parametrize('change', [
    lambda points: points, lambda points: points[::-1], lambda points: [*points, points[0]],
    lambda points: points[3:] + points[:3]])
def test_an_outline_is_extruded_upward(outline, area, change):
    path = generated_meshes.extruded([change(outline)], 0.5)
    # the triangles are anticlockwise seen from outside: the volume is positive
    assert volume(path) == pytest.approx(area / 2)
    corners = np.concatenate([part.positions for part in mesh_file.read(path)]).reshape(-1, 3)
    assert corners[:, 2].min() == 0 and corners[:, 2].max() == 0.5
    assert len(corners) == 3 * (4 * len(outline) - 4)


def square(size, x, y=None):
    y = x if y is None else y
    return [(x, y), (x + size, y), (x + size, y + size), (x, y + size)]


# the letter A of Gazebo's polyline.world
LETTER = [(2.08173, 0.7599), (2.4693, 0.7599), (3.4323, 3.28672), (3.07689, 3.28672),
          (2.84672, 2.63851), (1.7077, 2.63851), (1.47753, 3.28672), (1.11704, 3.28672)]
IN_LETTER = [(2.27467, 1.0967), (1.81094, 2.35418), (2.74009, 2.35418)]


@pytest.mark.parametrize('outlines, area', [
    ([square(4, 0), square(2, 1)], 12), ([square(2, 1)[::-1], square(4, 0)], 12),
    ([square(6, 0), square(1, 1), square(1, 3), square(1, 4, 1)], 33),
    ([square(6, 0), square(4, 1), square(1, 2)], 21), ([square(1, 0), square(2, 5)], 5),
    ([square(6, 0), square(2, 1, 2), square(2, 3.5, 2), square(1, 1.5, 2.5)], 29),
    ([IN_LETTER, LETTER], 1.94307)])
def test_an_outline_in_another_one_is_a_hole(outlines, area):
    path = generated_meshes.extruded(outlines, 0.5)
    assert volume(path) == pytest.approx(area / 2, rel=1e-4)
    edges = collections.Counter()
    for triangle in mesh_file.read(path)[0].positions.round(5).tolist():
        for start, end in zip(triangle, triangle[1:] + triangle[:1]):
            edges[tuple(start), tuple(end)] += 1
    assert all(edges[end, start] == count for (start, end), count in edges.items())   # closed


def test_an_outline_that_crosses_itself_is_written_all_the_same():
    part, = mesh_file.read(generated_meshes.extruded([[(0, 0), (1, 1), (1, 0), (0, 1)]], 1))
    caps = part.positions[np.ptp(part.positions[:, :, 2], axis=1) == 0]
    assert len(part.positions) == 12 and len(caps) == 4
    assert len(np.unique(caps.reshape(-1, 3), axis=0)) == 8


@pytest.mark.parametrize('count', [2, 1001])
def test_refuses_an_outline_of_too_few_or_too_many_corners(count):
    corners = [(x, x * x) for x in range(count)]
    assert refusal(generated_meshes.extruded, [corners], 1) == (
        'got an outline of {} different corners, expected 3 to 1000'.format(count))


def test_a_cache_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    (tmp_path / 'file').write_text('')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file'))
    assert refusal(generated_meshes.extruded, [L_SHAPE], 1).startswith(
        'cannot write to {}/file/'.format(tmp_path))


def test_textures_go_along_the_walls():
    part, = mesh_file.read(generated_meshes.extruded([[(0, 0), (3, 0), (3, 4)]], 0.5))
    is_cap = np.ptp(part.positions[:, :, 2], axis=1) == 0
    assert part.uvs[is_cap].tolist() == part.positions[is_cap][:, :, :2].tolist()
    along = {(0, 0): 5, (3, 0): 8, (3, 4): 12}
    for position, uv in zip(part.positions[~is_cap].reshape(-1, 3),
                            part.uvs[~is_cap].reshape(-1, 2)):
        assert uv.tolist() == [along[tuple(position[:2])], position[2]]


def test_a_corner_on_a_straight_side_gives_no_empty_triangle():
    part, = mesh_file.read(generated_meshes.extruded(
        [[(1, 0), (2, 0), (2, 1), (0, 1), (0, 0)]], 0.5))
    sides = part.positions[:, 1:] - part.positions[:, :1]
    assert np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1).min() > 0.1


def test_a_file_is_written_once_and_named_by_its_content(tmp_path, monkeypatch):
    vertices, uvs = np.array([(0, 1.5, 2), (1 / 3, 0, 0), (4, 5, 6)]), np.array([(0, 1)] * 3)
    monkeypatch.delenv('XDG_CACHE_HOME', raising=False)
    monkeypatch.setenv('HOME', str(tmp_path))
    path = generated_meshes.write(vertices, np.array([(0, 2, 1)]), uvs)
    text = ('v 0 1.5 2\nv 0.3333333 0 0\nv 4 5 6\nvt 0 1\nvt 0 1\nvt 0 1\n'
            'f 1/1 3/3 2/2\n')
    name = hashlib.sha256(text.encode()).hexdigest() + '.obj'
    assert path == str(tmp_path / '.cache' / 'img_recog' / 'generated_1' / name)
    with open(path) as file:
        assert file.read() == text
    os.utime(path, (1, 1))
    assert generated_meshes.write(vertices, np.array([(0, 2, 1)]), uvs) == path
    other = generated_meshes.write(vertices, np.array([(0, 1, 2)]), uvs)
    assert os.path.getmtime(path) == 1 and other != path
    assert set(os.listdir(os.path.dirname(path))) == {name, os.path.basename(other)}


def test_the_faces_of_a_grid():
    assert generated_meshes.grid_faces(2, 3).tolist() == [
        [0, 1, 4], [0, 4, 3], [1, 2, 5], [1, 5, 4]]
    assert generated_meshes.grid_faces(3, 2).tolist() == [
        [0, 1, 3], [0, 3, 2], [2, 3, 5], [2, 5, 4]]


def test_an_outline_without_an_area_is_written_all_the_same():
    part, = mesh_file.read(generated_meshes.extruded([[(0, 0), (1, 0), (2, 0), (1.5, 0)]], 1))
    caps = part.positions[(part.positions[:, :, 2] == 1).all(axis=1)]
    assert sorted(caps[:, :, 0].tolist()) == [[0, 1, 2], [0, 2, 1.5]]


def test_a_polyline_is_a_prism():
    element = ElementTree.fromstring(
        '<collision><geometry><polyline><point>1 2</point><point>3 2</point><point>1 5</point>'
        '<height>4</height></polyline></geometry></collision>')
    shape = sdf_links.solid(element, IDENTITY, lambda uri: None).shape
    part, = mesh_file.read(shape.path)
    corners = part.positions.reshape(-1, 3) * shape.size
    assert corners.min(axis=0) == pytest.approx([1, 2, 0])
    assert corners.max(axis=0) == pytest.approx([3, 5, 4])
