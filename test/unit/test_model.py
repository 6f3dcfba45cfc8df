"""The frames of what is drawn; inertias against what rigid bodies must do."""
import math

import numpy as np
import pytest

from img_recog.model import BODY_TO_OPENGL, NO_INERTIA, Inertia
from img_recog.rotations import IDENTITY, transform


@pytest.mark.parametrize('body, opengl', [
    ((0, 0, 0), (0, 0, 0)), ((1, 0, 0), (0, 0, -1)), ((0, 1, 0), (-1, 0, 0)),
    ((0, 0, 1), (0, 1, 0))], ids=['origin', 'ahead', 'left', 'up'])
def test_a_camera_body_looks_along_x_and_opengl_along_minus_z(body, opengl):
    assert (BODY_TO_OPENGL @ (*body, 1)).tolist() == [*opengl, 1]


def test_two_point_masses_make_a_dumbbell():
    left = Inertia(1.0, transform((0, 1, 0), (0, 0, 0)), np.zeros((3, 3)))
    right = Inertia(3.0, transform((0, -1, 0), (0, 0, 0)), np.zeros((3, 3)))
    both = left.plus(right)
    assert both.mass == 4.0
    assert np.allclose(both.pose.translation, [0, -0.5, 0])
    # reduced mass 3/4 kg, distance 2 m
    assert np.allclose(both.matrix, np.diag([3.0, 0.0, 3.0]))


def test_moving_an_inertia_turns_its_matrix():
    moved = NO_INERTIA.plus(Inertia(2.0, IDENTITY, np.diag([1.0, 2.0, 3.0])).moved(
        transform((5, 0, 0), (0, 0, math.pi / 2))))
    assert np.allclose(moved.pose.translation, [5, 0, 0])
    assert np.allclose(moved.matrix, np.diag([2.0, 1.0, 3.0]))


def test_no_inertia_adds_nothing():
    assert NO_INERTIA.plus(NO_INERTIA).mass == 0
    one = Inertia(2.0, transform((1, 2, 3), (0, 0, 0)), np.eye(3))
    total = one.plus(NO_INERTIA)
    assert total.mass == 2.0
    assert np.allclose(total.pose.translation, one.pose.translation)
    assert np.allclose(total.matrix, one.matrix)
