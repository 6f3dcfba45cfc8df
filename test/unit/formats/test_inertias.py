"""Inertias that no body can have: the nearest ones that a body can have, and a warning."""
import numpy as np
import pytest

from img_recog.formats import lumping
from img_recog.report import Report
from img_recog_helpers.refusals import refusal

TURN = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


def possible(*arguments):
    """Return an inertia, and the line about it or ''."""
    report = Report()
    return lumping.possible_inertia(*arguments, report), ''.join(report.lines())


@pytest.mark.parametrize('moments', [(1, 2, 2.99), (1, 2, 2.9999), (2, 2, 2), (1e-9, 1e-9, 1e-9),
                                     (1e15, 1e15, 1e15)])
@pytest.mark.parametrize('turn', [np.eye(3), TURN], ids=['level', 'turned'])
def test_what_a_body_can_have_stays_as_it_is(moments, turn):
    matrix = turn @ np.diag(np.array(moments, float)) @ turn.T
    found, line = possible('l', 1.0, matrix)
    assert found is matrix and line == ''


@pytest.mark.parametrize('given, nearest', [
    ((1, 1, 5), (2, 2, 4)),         # above the sum: on the plane of those that are equal to it
    ((3, 1, 0.5), (2.5, 1.5, 1)),
    ((-3, 1, 4), (0, 2.5, 2.5)),    # that plane too ends where a moment is 0
    ((0, 1, 1.3), (0.1, 1.1, 1.2))])
def test_the_nearest_inertia(given, nearest):
    found, line = possible('link w', 1.0, TURN @ np.diag(np.array(given, float)) @ TURN.T)
    assert found == pytest.approx(TURN @ np.diag(nearest) @ TURN.T, rel=1e-4, abs=1e-4)
    moments = np.linalg.eigvalsh(found)
    assert moments[0] > 0 and moments[0] + moments[1] > moments[2]
    assert line.startswith('link w: got the principal moments of inertia ')
    assert line.endswith('simulated with ' + ', '.join(
        map('{:.3g}'.format, moments)))


def test_a_thin_plate_is_simulated_without_a_warning():
    found, line = possible('l', 1.0, TURN @ np.diag((1.0, 2.0, 3.0)) @ TURN.T)
    assert line == ''
    assert np.linalg.eigvalsh(found) == pytest.approx((1, 2, 3), rel=1e-4)


@pytest.mark.parametrize('given', [(0, 0, 0), (-1, -2, -3)])
def test_a_body_without_any_moment_gets_those_of_a_small_one(given):
    found, line = possible('l', 3.0, np.diag(np.array(given, float)))
    assert found == pytest.approx(np.eye(3) * 3e-4)
    assert line.endswith('simulated with 0.0003, 0.0003, 0.0003')


@pytest.mark.parametrize('moment, text', [(1.1e15, '1.1e+15'), (1e15 + 0.5, '1e+15')])
def test_moments_that_are_too_large_are_refused(moment, text):
    assert refusal(lumping.possible_inertia, 'l', 1.0, np.diag((1, moment, 1)), Report()) == (
        'l: got the moment of inertia {} kg m2, expected at most 1e+15'.format(text))


# nearer to the limit than PyBullet can tell: a margin of 1e-5 of the largest moment
@pytest.mark.parametrize('given, nearest', [
    ((1, 2, 2.99999), (1.00003, 2.00003, 3.00002)), ((1, 1, 5), (2.00005, 2.00005, 4.00005)),
    ((-3, 1, 4), (4e-5, 2.50004, 2.50004)), ((-3, -2, 1), (1e-5, 1e-5, 1e-5)),
    ((0, 1, 1), (1e-5, 1.00001, 1.00001))])
def test_the_margin(given, nearest):
    found, line = possible('l', 1.0, np.diag(np.array(given, float)))
    assert np.diag(found) == pytest.approx(nearest, abs=1e-6)


@pytest.mark.parametrize('excess, is_said', [(0.006, False), (0.012, True)])
def test_a_small_change_is_not_worth_a_warning(excess, is_said):
    found, line = possible('l', 1.0, np.diag((1.0, 2.0, 3.0 + excess)))
    assert (line != '') is is_said


@pytest.mark.parametrize('mass, words', [
    (0, 'got 0 kg, expected more than 0'), (-1, 'got -1 kg, expected more than 0'),
    (1e-21, 'got 1e-21 kg, expected more than 0'), (1.1e9, 'kg, expected at most 1e+09')])
def test_masses_that_are_refused(mass, words):
    for good in (1e-20, 1, 1e9):
        lumping.check_mass('m', good)
    line = refusal(lumping.check_mass, 'm', mass, ' or none')
    assert line.startswith('m: got ') and line.endswith(words + ' or none')
