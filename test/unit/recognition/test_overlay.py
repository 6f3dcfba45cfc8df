"""The image with the result of the recognition: outlines, crosses, areas and commands."""
import zlib

import numpy as np
import pytest

from img_recog.recognition import overlay
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import Command
from img_recog.recognition.recognition_settings import with_colors

SETTINGS = with_colors()(red_area_limit=400)
BLUE, RED, GREY = (215, 70, 25), (60, 25, 215), (120, 120, 120)


def drawn(height, width, commands=()):
    """Return the image before and after, with a blue box of 400 px and a red one of 401 px."""
    image = np.full((height, width, 3), GREY, np.uint8)
    image[height // 2:height // 2 + 20, 40:60] = BLUE
    image[height // 2:height // 2 + 20, 100:120] = RED
    image[height // 2 + 20, 100] = RED
    extractor = ColorExtractor(SETTINGS)
    areas_px = extractor.measure(image)
    assert areas_px == [400, 401]
    before = image.copy()
    after = overlay.draw(extractor, SETTINGS.colors, areas_px, commands)
    assert np.array_equal(image, before) and after is not image
    return before, after


def test_outlines_have_the_bright_color_and_a_white_edge():
    _, image = drawn(240, 320)
    blue, red = map(overlay.bright_bgr, SETTINGS.colors)
    assert blue == (255, 182, 35) and red == (145, 35, 255)
    for row in (125, 135):
        assert tuple(image[row, 40]) == blue and tuple(image[row, 39]) == (255, 255, 255)
        assert tuple(image[row, 119]) == red and tuple(image[row, 120]) == (255, 255, 255)


def test_cross_is_at_the_centroid():
    _, image = drawn(240, 320)
    assert tuple(image[130, 50]) == (255, 255, 255) and tuple(image[130, 51]) == (255, 255, 255)
    assert tuple(image[131, 52]) == (0, 0, 0)


def test_texts_are_those_of_the_colors_then_of_the_commands(monkeypatch):
    written = []
    monkeypatch.setattr(overlay, '_write', lambda image, *rest: written.append(rest))
    drawn(240, 320, [Command(10.0), Command(-0.25, 1.5)])
    colors = [overlay.bright_bgr(color) for color in SETTINGS.colors]
    assert written == [('blue: 400 px <= 1000', 0, 0.4, colors[0]),
                       ('red: 401 px > 400', 1, 0.4, colors[1]),
                       ('command: 10 m/s, 0 rad/s', 2, 0.4, (255, 255, 255)),
                       ('command: -0.25 m/s, 1.5 rad/s', 3, 0.4, (255, 255, 255))]


@pytest.mark.parametrize('height, width, checksum', [
    (240, 320, 2552787383), (1080, 1920, 150949164), (1800, 400, 332343686)])
def test_every_pixel_is_as_it_was(height, width, checksum):
    _, image = drawn(height, width, [Command(10.0)])
    found = zlib.crc32(image.tobytes())
    assert found == checksum
