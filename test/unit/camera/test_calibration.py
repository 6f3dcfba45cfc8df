"""Calibrations: which are usable, and scaling to another image size."""
import dataclasses

import pytest

from img_recog.camera import calibration
from img_recog.camera.calibration import Calibration, CalibrationError
from img_recog_testing.calibrations import BROKEN, KNOWN


@pytest.mark.parametrize('broken, words', BROKEN)
def test_calibration_that_cannot_rectify_is_refused(broken, words):
    given = dataclasses.replace(KNOWN, **broken)
    with pytest.raises(CalibrationError, match='^the calibration has no usable entry ' + words):
        calibration.check(given)


@pytest.mark.parametrize('model, count', [
    ('plumb_bob', 5), ('plumb_bob', 4), ('rational_polynomial', 8), ('rational_polynomial', 12),
    ('rational_polynomial', 14), ('equidistant', 4)])
def test_models_have_the_coefficients_that_opencv_accepts(model, count):
    calibration.check(dataclasses.replace(
        KNOWN, distortion_model=model, distortion=(0.1,) * count))


def test_scaled_to_half_the_size():
    small = calibration.scaled(KNOWN, 320, 240)
    assert (small.width, small.height) == (320, 240)
    assert small.camera_matrix == (250.25, 0.0, 160.0, 0.0, 250.625, 120.0, 0.0, 0.0, 1.0)
    assert small.projection == (250.25, 0.0, 160.0, -5e-18, 0.0, 250.625, 120.0, 0.0, 0.0, 0.0,
                                1.0, 0.0)
    assert (small.distortion, small.rectification, small.camera_name) == (
        KNOWN.distortion, KNOWN.rectification, KNOWN.camera_name)


def test_scaled_to_its_own_size_is_itself():
    assert calibration.scaled(KNOWN, 640, 480) is KNOWN


def test_scaled_to_a_rounded_size():
    wide = Calibration('wide', 1920, 1080, 'plumb_bob', (0.0,) * 5, KNOWN.camera_matrix,
                       KNOWN.rectification, KNOWN.projection)
    assert calibration.scaled(wide, 854, 480).width == 854


@pytest.mark.parametrize('size', [(640, 360), (480, 640), (640, 470), (1, 480)])
def test_another_aspect_ratio_is_refused(size):
    with pytest.raises(CalibrationError, match='^the calibration is for 640x480, the images are '
                                               '{}x{}, another aspect ratio$'.format(*size)):
        calibration.scaled(KNOWN, *size)


def test_calibration_without_a_size_is_refused():
    empty = Calibration('x', 0, 0, 'plumb_bob', (), KNOWN.camera_matrix, KNOWN.rectification,
                        KNOWN.projection)
    with pytest.raises(CalibrationError):
        calibration.scaled(empty, 640, 480)


@pytest.mark.parametrize('size, usable', [
    ((646, 480), True), ((647, 480), False), ((640, 484), True), ((640, 485), False)])
def test_aspect_ratio_may_differ_by_one_percent(size, usable):
    if usable:
        matrix = calibration.scaled(KNOWN, *size).camera_matrix
        assert matrix[0] == pytest.approx(500.5 * size[0] / 640)
    else:
        with pytest.raises(CalibrationError):
            calibration.scaled(KNOWN, *size)


@pytest.mark.parametrize('width, height', [(0, 480), (640, 0), (-640, -480), (-640, 480)])
def test_calibration_with_half_a_size_is_refused(width, height):
    with pytest.raises(CalibrationError, match='another aspect ratio'):
        calibration.scaled(dataclasses.replace(KNOWN, width=width, height=height), 320, 240)
    with pytest.raises(CalibrationError, match='another aspect ratio'):
        calibration.scaled(dataclasses.replace(KNOWN, height=0), KNOWN.width, 240)
    with pytest.raises(CalibrationError):
        calibration.scaled(KNOWN, 0, 480)
    with pytest.raises(CalibrationError):
        calibration.scaled(KNOWN, 640, 0)


@pytest.mark.parametrize('index, name', [(0, 'fx'), (4, 'fy')])
@pytest.mark.parametrize('value, usable', [(0.0, False), (-1.0, False), (0.5, True)])
def test_both_focal_lengths_are_above_zero(index, name, value, usable):
    matrix = list(KNOWN.camera_matrix)
    matrix[index] = value
    problem = calibration.find_problem(dataclasses.replace(KNOWN, camera_matrix=tuple(matrix)))
    assert problem == (None if usable else 'camera_matrix (wants a focal length {} above 0, has '
                       '{:g})'.format(name, value))


def test_one_pixel_is_a_size():
    assert calibration.find_problem(dataclasses.replace(KNOWN, width=1, height=1)) is None


@pytest.mark.parametrize('value, shown', [
    ([1, 2, 3, 4], '[1, 2, 3, ...]'), ([1, 2, 3], '[1, 2, 3]'),
    ({number: 0 for number in range(4)}, '{0: 0, 1: 0, 2: 0, ...}'),
    ({1: 0, 2: 0, 3: 0}, '{1: 0, 2: 0, 3: 0}'), ([[[[]]]], '[[[...]]]'), ([[[]]], '[[[]]]'),
    ('a' * 58, repr('a' * 58)), ('a' * 59, repr('a' * 27 + '...' + 'a' * 28)),
    (10 ** 59, '1' + '0' * 59), (10 ** 60, '1' + '0' * 27 + '...' + '0' * 29),
    (b'x' * 57, repr(b'x' * 57)), (b'x' * 58, "b'" + 'x' * 26 + '...' + 'x' * 28 + "'")])
def test_values_are_shortened(value, shown):
    assert calibration.short_repr(value) == shown
