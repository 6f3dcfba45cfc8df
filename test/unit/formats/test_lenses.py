"""Where lenses show a direction, and what is seen in a place of their images."""
import math

import numpy as np
import pytest

from img_recog.formats import lenses
from img_recog.formats.lenses import ID, SIN, TAN, Lens

# the radius at an angle of 1 rad, by the formulas of the projections with focal length 1
AT_ONE = {'gnomonical': math.tan(1), 'stereographic': 2 * math.tan(0.5), 'equidistant': 1.0,
          'equisolid_angle': 2 * math.sin(0.5), 'orthographic': math.sin(1)}


@pytest.mark.parametrize('kind', sorted(AT_ONE))
def test_the_types_of_sdf(kind):
    lens = lenses.of_type(kind)
    assert lens.radius(1.0) == pytest.approx(AT_ONE[kind])
    assert lens.angle(AT_ONE[kind]) == pytest.approx(1.0)


def test_an_offset_moves_the_middle():
    lens = Lens(0.5, 2.0, 0.1, TAN)
    assert lens.radius(0.8) == pytest.approx(0.5 * math.tan(0.8 / 2 + 0.1))
    assert lens.angle(lens.radius(0.8)) == pytest.approx(0.8)
    assert np.isnan(lens.angle(0.01))       # it would be left of the axis


def test_beyond_the_function_and_the_cutoff_nothing_is_seen():
    assert np.isnan(lenses.of_type('orthographic').angle(1.01))
    angles = Lens(1.0, cutoff_angle=1.0).angle(np.array([0.99, 1.01]))
    assert angles[0] == 0.99 and np.isnan(angles[1])
    assert Lens(1.0, cutoff_angle=1.0).angle([0.0, 1.0]).tolist() == [0.0, 1.0]
    assert Lens(2.0) == (2.0, 1.0, 0.0, 'id', math.pi, 256)
    assert np.isnan(Lens(1.0, cutoff_angle=9.0).angle(math.pi + 0.01))      # behind the back


@pytest.mark.parametrize('lens, fov', [
    (Lens(1.0, 1.0, 0.0, TAN), 3.3), (Lens(1.0, 1.0, -2.0, ID), 3.3),
    (Lens(1.0, 0.5, 0.0, SIN), 3.3), (Lens(1.0, 0.5, 0.0, TAN), 3.3),
    (Lens(1.0, 1.0, 0.0, TAN), math.pi)])
def test_a_field_of_view_that_the_function_does_not_have(lens, fov):
    with pytest.raises(ValueError):
        lenses.scaled_to(lens, fov)


@pytest.mark.parametrize('lens, fov, scale', [
    (Lens(7.0), 5.0, 0.4), (Lens(7.0, 2.0, 0.1), 3.2, 1 / 0.9), (Lens(7.0), 1e-2, 200.0),
    (Lens(3.0, 2.0, 0.0, TAN, 1.0, 64), math.pi, 1.0)])
def test_the_scale_of_a_field_of_view(lens, fov, scale):
    found = lenses.scaled_to(lens, fov)
    assert found.scale == pytest.approx(scale) and found[1:] == lens[1:]
    assert found.radius(fov / 2) == pytest.approx(1)
