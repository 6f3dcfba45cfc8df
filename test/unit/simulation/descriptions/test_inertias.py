"""Inertias that no body can have: the nearest ones that a body can have, and a warning."""
import numpy as np
import pytest

from img_recog.simulation.descriptions import inertias
from img_recog_testing.refusals import refusal

TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


@pytest.mark.parametrize('moments', [(1, 2, 2.99), (1e-9, 1e-9, 1e-9), (1e15, 1e15, 1e15)])
def test_what_a_body_can_have_stays_as_it_is(moments):
    matrix = TURN @ np.diag(np.array(moments, float)) @ TURN.T
    found = inertias.possible('l', 1.0, matrix)
    assert found.matrix is matrix and found.warning == ''


@pytest.mark.parametrize('given, nearest', [
    ((1, 1, 5), (2, 2, 4)),         # above the sum: on the plane of those that are equal to it
    ((3, 1, 0.5), (2.5, 1.5, 1)),
    ((-3, 1, 4), (0, 2.5, 2.5)),    # that plane too ends where a moment is 0
    ((0, 1, 1.3), (0.1, 1.1, 1.2))])
def test_the_nearest_inertia(given, nearest):
    found = inertias.possible('link w', 1.0, TURN @ np.diag(np.array(given, float)) @ TURN.T)
    assert found.matrix == pytest.approx(TURN @ np.diag(nearest) @ TURN.T, rel=1e-4, abs=1e-4)
    moments = np.linalg.eigvalsh(found.matrix)
    assert moments[0] > 0 and moments[0] + moments[1] > moments[2]
    assert found.warning.startswith('link w: got the principal moments of inertia ')
    assert found.warning.endswith('simulated with ' + ', '.join(
        map('{:.3g}'.format, moments)))


def test_a_thin_plate_is_simulated_without_a_warning():
    found = inertias.possible('l', 1.0, TURN @ np.diag((1.0, 2.0, 3.0)) @ TURN.T)
    assert found.warning == ''
    assert np.linalg.eigvalsh(found.matrix) == pytest.approx((1, 2, 3), rel=1e-4)


@pytest.mark.parametrize('given', [(0, 0, 0), (-1, -2, -3)])
def test_a_body_without_any_moment_gets_those_of_a_small_one(given):
    found = inertias.possible('l', 3.0, np.diag(np.array(given, float)))
    assert found.matrix == pytest.approx(np.eye(3) * 3e-4)
    assert found.warning.endswith('simulated with 0.0003, 0.0003, 0.0003')


def test_moments_that_are_too_large_are_refused():
    assert refusal(inertias.possible, 'l', 1.0, np.diag((1, 1.1e15, 1))) == (
        'l: got the moment of inertia 1.1e+15 kg m2, expected at most 1e+15')
