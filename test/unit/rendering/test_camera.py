"""A pinhole camera."""
import math

import pytest

from img_recog.rendering.camera import Camera


def test_intrinsics():
    camera = Camera(640, 480, math.radians(60))
    fx, fy, cx, cy = camera.intrinsics
    assert fx == fy == pytest.approx(320 / math.tan(math.radians(30)))
    assert (cx, cy) == (319.5, 239.5)


def test_slopes_are_those_of_half_the_field_of_view():
    window = Camera(640, 480, math.radians(90)).window
    assert window == pytest.approx((-1.0, 1.0, -0.75, 0.75))
