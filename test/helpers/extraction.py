"""Color extractors and images for the tests of the recognition."""
import numpy as np

from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.recognition_settings import with_colors


def extractor(**values):
    """Return an extractor with the colors of the article, some of whose settings differ."""
    return ColorExtractor(with_colors()(**values))


def random_image(seed, shape=(48, 64, 3)):
    """Return an image of noise, uint8."""
    return np.random.RandomState(seed).randint(0, 256, shape).astype(np.uint8)
