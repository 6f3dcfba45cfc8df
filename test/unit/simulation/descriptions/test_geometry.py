"""Transforms and inertias against what rigid bodies must do."""
import math

import numpy as np

from img_recog.simulation.descriptions.geometry import NO_INERTIA, Inertia, from_rpy


def test_rpy_turns_about_fixed_axes_roll_first():
    # roll takes y to z, then yaw of a quarter turn leaves z alone and takes x to y
    turned = from_rpy((1, 2, 3), (math.pi / 2, 0, math.pi / 2))
    assert np.allclose(turned.apply(np.array([0, 1, 0])), [1, 2, 4])
    assert np.allclose(turned.apply(np.array([1, 0, 0])), [1, 3, 3])


def test_transforms_compose():
    a, b = from_rpy((1, 0, 0), (0, 0, math.pi / 2)), from_rpy((0, 2, 0), (0.4, 0, 0))
    point = np.array([0.3, -0.2, 0.5])
    assert np.allclose((a @ b).apply(point), a.apply(b.apply(point)))


def test_the_inverse_takes_points_back():
    pose = from_rpy((1, -2, 3), (0.4, -0.3, 2.0))
    point = np.array([0.3, -0.2, 0.5])
    assert np.allclose(pose.inverse.apply(pose.apply(point)), point)
    assert np.allclose((pose @ pose.inverse).matrix(), np.eye(4))


def test_a_homogeneous_matrix_moves_points_like_the_transform():
    pose = from_rpy((1, -2, 3), (0.4, -0.3, 2.0))
    point = np.array([0.3, -0.2, 0.5])
    assert np.allclose(pose.matrix() @ (*point, 1.0), (*pose.apply(point), 1.0))


def test_two_point_masses_make_a_dumbbell():
    left = Inertia(1.0, np.array([0.0, 1.0, 0.0]), np.zeros((3, 3)))
    right = Inertia(3.0, np.array([0.0, -1.0, 0.0]), np.zeros((3, 3)))
    both = left + right
    assert both.mass == 4.0
    assert np.allclose(both.center, [0, -0.5, 0])
    # reduced mass 3/4 kg, distance 2 m
    assert np.allclose(both.matrix, np.diag([3.0, 0.0, 3.0]))


def test_moving_an_inertia_turns_its_matrix():
    moved = Inertia(2.0, np.zeros(3), np.diag([1.0, 2.0, 3.0])).moved(
        from_rpy((5, 0, 0), (0, 0, math.pi / 2)))
    assert np.allclose(moved.center, [5, 0, 0])
    assert np.allclose(moved.matrix, np.diag([2.0, 1.0, 3.0]))


def test_no_inertia_adds_nothing():
    assert (NO_INERTIA + NO_INERTIA).mass == 0
    one = Inertia(2.0, np.array([1.0, 2.0, 3.0]), np.eye(3))
    total = one + NO_INERTIA
    assert total.mass == 2.0
    assert np.allclose(total.center, one.center) and np.allclose(total.matrix, one.matrix)
