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
