"""Rotations in their three forms, against each other and against PyBullet."""
import math

import numpy as np
import pybullet
import pytest

from img_recog import rotations
from img_recog.rotations import transform

ANGLES = [(0, 0, 0), (0.3, -0.7, 2.0), (-1.57, 0, 0), (3.0, 1.2, -3.0), (0, math.pi / 2, 0.4),
          (0.5, -math.pi / 2, 0)]
QUATERNIONS = [(0.0, 0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0),
               (0.0, 0.0, 1.0, 0.0), (0.1, 0.2, 0.3, math.sqrt(0.86)), (0.5, -0.5, 0.5, 0.5)]


@pytest.mark.parametrize('rpy', ANGLES)
def test_rpy_round_trip(rpy):
    rotation = rotations.from_rpy(rpy)
    assert np.allclose(rotations.from_rpy(rotations.to_rpy(rotation)), rotation, atol=1e-9)
    assert np.allclose(rotation @ rotation.T, np.eye(3))


@pytest.mark.parametrize('rpy', ANGLES)
def test_the_quaternion_of_a_matrix_is_pybullets(rpy):
    found = np.array(rotations.quaternion_of(rotations.from_rpy(rpy)))
    assert abs(found @ pybullet.getQuaternionFromEuler(rpy)) == pytest.approx(1.0)


@pytest.mark.parametrize('length', [1.0, 3.0])
@pytest.mark.parametrize('quaternion', QUATERNIONS)
def test_the_matrix_of_a_quaternion_is_pybullets(quaternion, length):
    longer = tuple(length * value for value in quaternion)
    expected = np.reshape(pybullet.getMatrixFromQuaternion(quaternion), (3, 3))
    assert rotations.matrix(longer) == pytest.approx(expected)
    assert abs(np.dot(rotations.quaternion_of(expected), quaternion)) == pytest.approx(1.0)
    vectors = (1.0, 2.0, 3.0), (-4.0, 5.0, 0.5)
    assert np.array(rotations.into_frame(longer, *vectors)) == pytest.approx(
        np.array(vectors) @ expected)


def test_elements_of_many_quaternions():
    each = [rotations.elements(*quaternion) for quaternion in QUATERNIONS]
    assert np.array_equal(np.transpose(rotations.elements(*np.transpose(QUATERNIONS))), each)


@pytest.mark.parametrize('quaternion, yaw', [
    (QUATERNIONS[0], 0.0), (rotations.of_yaw(0.8), 0.8), (QUATERNIONS[1], 0.0),
    ((0.5, 0.5, 0.5, 0.5), math.pi / 2), (QUATERNIONS[2], math.pi),
    ((0.0, 0.0, 2.0, -2.0), -math.pi / 2),
    (QUATERNIONS[4], math.atan2(2 * (0.3 * math.sqrt(0.86) + 0.02), 1 - 2 * (0.04 + 0.09)))])
def test_yaw(quaternion, yaw):
    assert math.cos(rotations.yaw(quaternion) - yaw) == pytest.approx(1.0)


def test_transforms_compose_and_have_an_inverse_and_a_matrix():
    a, b = transform((1, 0, 0), (0, 0, math.pi / 2)), transform((1, -2, 3), (0.4, -0.3, 2.0))
    point = np.array([0.3, -0.2, 0.5])
    assert np.allclose((a @ b).apply(point), a.apply(b.apply(point)))
    assert np.allclose(b.inverse.apply(b.apply(point)), point)
    assert np.allclose((b @ b.inverse).matrix(), np.eye(4))
    assert np.allclose(b.matrix() @ (*point, 1.0), (*b.apply(point), 1.0))
