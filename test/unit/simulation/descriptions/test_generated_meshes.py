"""Meshes of outlines: closed, of the right volume, and seen from outside."""
import os

import numpy as np
import pytest

from img_recog import mesh_file
from img_recog.simulation.descriptions import generated_meshes
from img_recog_testing.refusals import refusal

# an L of 3 m2, anticlockwise
L_SHAPE = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
# a comb, whose ears lie between other corners, and a spiral
COMB = [(0, 0), (5, 0), (5, 2), (4, 2), (4, 1), (3, 1), (3, 2), (2, 2), (2, 1), (1, 1), (1, 2),
        (0, 2)]
SPIRAL = [(0, 0), (4, 0), (4, 4), (1, 4), (1, 2), (2, 2), (2, 3), (3, 3), (3, 1), (0, 1)]


def volume(path):
    corners = np.concatenate([part.positions for part in mesh_file.read(path)])
    return np.einsum('ij,ij->i', corners[:, 0], np.cross(corners[:, 1], corners[:, 2])).sum() / 6


@pytest.mark.parametrize('outline, area', [(L_SHAPE, 3), (COMB, 8), (SPIRAL, 10)])
@pytest.mark.parametrize('change', [
    lambda points: points, lambda points: points[::-1], lambda points: [*points, points[0]],
    lambda points: points[3:] + points[:3]])
def test_an_outline_is_extruded_upward(outline, area, change):
    path = generated_meshes.extruded(change(outline), 0.5)
    # the triangles are anticlockwise seen from outside: the volume is positive
    assert volume(path) == pytest.approx(area / 2)
    corners = np.concatenate([part.positions for part in mesh_file.read(path)]).reshape(-1, 3)
    assert corners[:, 2].min() == 0 and corners[:, 2].max() == 0.5


def test_an_outline_that_crosses_itself_is_written_all_the_same():
    assert os.path.isfile(generated_meshes.extruded([(0, 0), (1, 1), (1, 0), (0, 1)], 1))


@pytest.mark.parametrize('count', [2, 1001])
def test_refuses_an_outline_of_too_few_or_too_many_corners(count):
    corners = [(x, x * x) for x in range(count)]
    assert refusal(generated_meshes.extruded, corners, 1) == (
        'got an outline of {} different corners, expected 3 to 1000'.format(count))


def test_a_cache_that_cannot_be_written_is_named(tmp_path, monkeypatch):
    (tmp_path / 'file').write_text('')
    monkeypatch.setenv('XDG_CACHE_HOME', str(tmp_path / 'file'))
    assert refusal(generated_meshes.extruded, L_SHAPE, 1).startswith(
        'cannot write to {}/file/'.format(tmp_path))
