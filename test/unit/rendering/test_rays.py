"""What pixels look at, and whether the camera model says the same."""
import math

import cv2
import numpy as np
import pytest

from img_recog.formats import lenses
from img_recog.formats.lenses import Distortion, Lens
from img_recog.rendering.camera import Camera
from img_recog.rendering.lens_views import directions, model_of

CUSTOM = lenses.scaled_to(Lens(1.05, 4.0, 0.0, 'tan'), 3.183)


def camera(lens, fov=2.0, size=(64, 48)):
    return Camera(*size, fov, lens=lens)


def test_the_intrinsics_and_the_window_of_a_pinhole_camera():
    fx, fy, cx, cy = Camera(640, 480, math.radians(60)).intrinsics
    assert fx == fy == pytest.approx(320 / math.tan(math.radians(30)))
    assert (cx, cy) == (319.5, 239.5)
    assert Camera(640, 480, math.radians(90)).edges == pytest.approx((-1.0, 1.0, -0.75, 0.75))


def matrix(model):
    fx, fy, cx, cy = model.intrinsics
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def test_directions_are_shared_and_cannot_be_changed():
    assert not directions(camera(None)).flags.writeable


def places(model, rays):
    """Return where OpenCV's functions for a model project directions, (n, 2) px."""
    points, zero = rays.reshape(-1, 1, 3), np.zeros(3)
    project = {'plumb_bob': cv2.projectPoints, 'equidistant': cv2.fisheye.projectPoints}
    return project[model.model](points, zero, zero, matrix(model), np.array(model.coefficients))[
        0].reshape(-1, 2)


@pytest.mark.parametrize('lens, fov', [
    (None, 1.2), (Distortion(-0.2, 0.03, 0.002, -0.001, 0.01), 1.2),
    *((lenses.scaled_to(lenses.of_type(kind), 2.0), 2.0) for kind in lenses.TYPES[:-1]),
    (CUSTOM, 3.183)])
def test_the_model_projects_to_the_pixels(lens, fov):
    given = camera(lens, fov)
    model, rays = model_of(given), directions(given)
    rows, columns = np.mgrid[:48, :64]
    ahead = rays[..., 2] > 0.05         # as cv2.fisheye projects only those
    assert ahead.mean() > 0.6
    found = places(model, rays[ahead])
    assert np.abs(found - np.stack([columns, rows], axis=-1)[ahead]).max() < 0.1


@pytest.mark.parametrize('lens, name', [
    (lenses.of_type('gnomonical'), 'plumb_bob'), (lenses.of_type('equidistant'), 'equidistant'),
    (CUSTOM, 'equidistant'), (None, 'plumb_bob')])
def test_the_name_of_the_model(lens, name):
    assert model_of(camera(lens)).model == name


def test_an_equidistant_lens_has_no_coefficients():
    model = model_of(camera(lenses.scaled_to(lenses.of_type('equidistant'), math.pi)))
    assert model.coefficients == (0.0,) * 4
    assert model.intrinsics == pytest.approx((64 / math.pi, 64 / math.pi, 31.5, 23.5))


def test_a_lens_that_no_model_can_say():
    assert model_of(camera(Lens(0.5, 1.0, 0.2, 'tan'))) is None
    assert model_of(camera(Lens(0.02, 1.1, 0.0, 'tan'))) is None    # nearly to the limit of tan
    assert model_of(camera(Lens(1.0, 2.0, 0.0, 'sin', 1e-6))) is None   # which sees nothing


def test_what_a_distortion_cannot_reach_is_black():
    rays = directions(camera(Distortion(-0.5, 0.0, 0.0, 0.0, 0.0), 2.2))
    assert np.isnan(rays[0, 0]).all() and np.isfinite(rays[24]).any()
    norms = np.linalg.norm(rays[np.isfinite(rays[..., 2])], axis=1)
    assert norms == pytest.approx(1)
