"""Images that are measured while they arrive, and masked images drawn over older ones."""
import cv2
import numpy as np
import pytest

from img_recog.recognition.areas import ENCODINGS
from img_recog.recognition.settings import with_colors
from img_recog_testing.extraction import extractor, random_image


def scene(seed, encoding, shape=(48, 64)):
    """Return an image with a grey background and colored rectangles, in an encoding."""
    random = np.random.RandomState(seed)
    image = np.full(shape + (3,), 120, np.uint8)
    for color in ((215, 70, 25), (60, 25, 215), (25, 200, 60)):
        top, left = random.randint(0, shape[0]), random.randint(0, shape[1])
        image[top:top + random.randint(0, 12), left:left + random.randint(0, 30)] = color
    return {'bgr8': image, 'rgb8': np.ascontiguousarray(image[..., ::-1]),
            'bgra8': np.dstack([image, image[..., 0]]),
            'rgba8': np.dstack([image[..., ::-1], image[..., 0]])}[encoding], image


@pytest.mark.parametrize('values', [
    {}, {'roi_x_offset': 8, 'roi_width': 40}, {'blue_column_min': 0.25}, {'min_blob_size': 9}])
@pytest.mark.parametrize('shape', [(48, 64), (7, 9)])
@pytest.mark.parametrize('encoding', ENCODINGS)
def test_images_drawn_one_over_the_other(encoding, shape, values):
    """Each one is drawn into the memory of one of the last three, with the note about it."""
    found = extractor(**values)
    plain = extractor(**values)
    memories = [(np.full(shape + (3,), 77, np.uint8), None) for _ in range(3)]
    for seed in range(60):
        image, bgr = scene(seed, encoding, shape)
        if seed % 20 == 13:
            image = bgr = random_image(seed, shape + (3,))      # is processed as a whole
        kind = 'bgr8' if image is bgr else encoding
        found.measure(image, kind)
        plain.measure(bgr)
        for number in range(2):
            memory, note = memories.pop(0)
            note = found.draw_masked(number, memory, note)
            memories.append((memory, note))
            assert np.array_equal(memory, cv2.bitwise_and(bgr, bgr, mask=plain.mask(number)))
            assert np.array_equal(memory, found.masked(number))


def test_an_image_that_arrives_row_by_row():
    found, plain = extractor(roi_y_offset=100, roi_height=900), extractor(roi_y_offset=100,
                                                                          roi_height=900)
    for seed in range(3):
        image, _ = scene(seed, 'rgb8', (1080, 1920))
        memory, rows = np.zeros_like(image), 0
        wanted = []
        for rows in found.begin(memory, 'rgb8'):
            wanted.append(rows)
            memory[:rows] = image[:rows]
        assert wanted == sorted(wanted) and len(wanted) == 8 and 100 < wanted[0] < rows < 1000
        memory[:] = image
        assert found.finish() == plain.measure(image, 'rgb8')
        for number in range(2):
            assert np.array_equal(found.masked(number), plain.masked(number))


def test_other_settings_while_an_image_arrives_apply_to_the_next_one():
    image, found = random_image(3), extractor()
    wanted = found.measure(image)
    found.begin(image, 'bgr8')
    found.configure(with_colors()(blue_hue_min=100))
    assert found.finish() == wanted
    assert found.measure(image)[0] < wanted[0]
