"""The synthetic scene: its cards, its sizes, and that its frames are reproducible."""
import zlib

import cv2
import numpy as np
import pytest

from img_recog.camera.synthetic import (BLUE_FRAMES, PERIOD_FRAMES, RED_FRAMES, SyntheticSource,
                                        draw_frame)
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.recognition_settings import with_colors

KEY_FRAMES = {'empty': (0, 29, 90), 'blue': (30, 31, 32, 33, 34, 89), 'red': (180, 239)}
SETTINGS = with_colors()()


def areas_px(frame):
    bgr = cv2.cvtColor(frame, cv2.COLOR_RGB2BGR)
    return tuple(ColorExtractor(SETTINGS).measure(bgr))


def test_every_pixel_is_as_it_was():
    # the figures of the benchmark and the expected commands of other tests depend on the scene
    numbers = (0, 30, 31, 32, 33, 34, 85, 86, 87, 88, 89, 180, 210)
    assert [zlib.crc32(draw_frame(number).tobytes()) for number in numbers] == [
        3062879616, 3485339005, 3231330658, 3149169198, 296083910, 3840171824,
        3840171824, 296083910, 3149169198, 3231330658, 3485339005,      # it leaves as it came
        417036072, 1256572388]


def test_cards_have_at_least_20000_px_of_their_color_and_other_frames_have_none():
    measured = {}       # most frames are equal
    for number in range(PERIOD_FRAMES):
        frame = draw_frame(number)
        content = zlib.crc32(frame.tobytes())
        if content not in measured:
            measured[content] = areas_px(frame)
        blue, red = measured[content]
        assert (blue >= 20000) if number in BLUE_FRAMES else (blue == 0), number
        assert (red >= 20000) if number in RED_FRAMES else (red == 0), number


@pytest.mark.parametrize('width, height', [(320, 240), (1920, 1080), (333, 77)])
def test_every_size_shows_the_cards_in_proportion(width, height):
    enough = 20000 * width * height / (640 * 480) * 0.95
    for card, numbers in KEY_FRAMES.items():
        for number in numbers:
            frame = draw_frame(number, width, height)
            assert frame.shape == (height, width, 3) and frame.dtype == np.uint8
            blue, red = areas_px(frame)
            assert (blue >= enough) if card == 'blue' else (blue == 0), (number, blue)
            assert (red >= enough) if card == 'red' else (red == 0), (number, red)


@pytest.mark.parametrize('width, height', [(1, 1), (2, 3), (16, 1)])
def test_smallest_sizes_are_drawn(width, height):
    for number in (0, 60, 210):
        frame = draw_frame(number, width, height)
        assert frame.shape == (height, width, 3)
        assert np.array_equal(draw_frame(number + 7 * PERIOD_FRAMES, width, height), frame)


@pytest.mark.parametrize('width, height', [(320, 240), (64, 48)])
def test_source_yields_the_frames_of_the_scene_in_order(width, height):
    source = SyntheticSource(width, height, 15.0)
    assert (source.width, source.height, source.rate_hz) == (width, height, 15.0)
    assert (source.encoding, source.name, source.expected_hz) == ('rgb8', 'synthetic', 15.0)
    assert source.description == 'synthetic scene, {}x{}, 15 Hz'.format(width, height)
    for number in range(PERIOD_FRAMES + 35):        # the period repeats
        frame = draw_frame(BLUE_FRAMES.start + number, width, height)
        image = source.read()
        assert np.array_equal(image, frame) and not image.flags.writeable, number
    source.close()
    source.close()
