"""Pictures in another light."""
import numpy as np
import pytest

from img_recog.rendering.light import LightFilter, LightSettings, gains_of
from img_recog.settings import SettingError


def seen(color, **settings):
    image = np.full((2, 3, 3), color, np.uint8)
    LightFilter(LightSettings(**settings)).apply(image)
    assert (image == image[0, 0]).all()
    return image[0, 0].tolist()


def test_daylight_changes_nothing():
    assert seen((200, 100, 7)) == [200, 100, 7]


def test_a_light_bulb_is_orange_and_the_sky_is_blue():
    red, green, blue = seen((128, 128, 128), light_temperature=2700)
    assert red > 160 and 105 < green < 125 and blue < 75
    red, _, blue = seen((128, 128, 128), light_temperature=12000)
    assert blue > 145 and red <= 116


@pytest.mark.parametrize('kelvin, chromaticity', [
    # of a black body, from tables of the Planckian locus (CIE 1931, 2 degrees)
    (2000, (0.5267, 0.4133)), (2856, (0.4476, 0.4074)), (10000, (0.2807, 0.2883))])
def test_a_white_surface_has_the_color_of_a_black_body(kelvin, chromaticity):
    from_rgb = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722],
                         [0.0193, 0.1192, 0.9505]])
    daylight = from_rgb @ gains_of(6500)
    assert daylight == pytest.approx(from_rgb @ np.ones(3))
    # sRGB's white, D65, is 0.006 from the black body of 6500 K; 2000 K has no blue in sRGB
    x, y, z = from_rgb @ gains_of(kelvin)
    assert (x / (x + y + z), y / (x + y + z)) == pytest.approx(chromaticity, abs=0.02)


def test_twice_the_exposure_is_twice_the_light():
    # in sRGB, 188 is twice the light of 137
    assert seen((137, 137, 137), light_exposure=2.0) == pytest.approx([188] * 3, abs=1)
    assert seen((250, 250, 250), light_exposure=4.0) == [255] * 3


def test_what_is_no_light():
    with pytest.raises(SettingError, match='light_temperature: got 100.0'):
        LightSettings(light_temperature=100.0)
