"""The images of the benchmarks: frames of a film, and of noise."""
import os
import sys
from typing import List

import cv2
import numpy as np

_FILM = os.path.join(os.path.dirname(os.path.abspath(__file__)), os.pardir, 'test', 'data',
                     'bikes.mp4')
_FILM_CARD, _FILM_CARD_RGB = (0.15, 0.15), (30, 60, 200)       # its share of the width and height
_RED, _GREY = ((150, 100, 150), (180, 255, 255)), 128           # the article's range
_FRAMES = 10                    # of each kind


def film(width: int, height: int) -> List[np.ndarray]:
    """Return frames of a film, with people and bicycles in a street, into which a card is held.

    There is one command for each frame: the card is blue, and what is red in the film is grey.
    """
    capture = cv2.VideoCapture(_FILM)
    frames = []
    while True:
        is_read, frame = capture.read()
        if not is_read:
            break
        frames.append(frame)
    if len(frames) < _FRAMES:
        sys.exit('cannot read {}: ./run bench gets it'.format(_FILM))
    images = [cv2.cvtColor(cv2.resize(frame, (width, height)), cv2.COLOR_BGR2RGB)
              for frame in frames[::len(frames) // _FRAMES][:_FRAMES]]
    card_width, card_height = (round(share * size)
                               for share, size in zip(_FILM_CARD, (width, height)))
    for number, image in enumerate(images):
        hsv = cv2.cvtColor(image, cv2.COLOR_RGB2HSV)
        image[cv2.inRange(hsv, *_RED) > 0] = _GREY
        left = (width - card_width) * number // len(images)
        top = height // 2
        image[top:top + card_height, left:left + card_width] = _FILM_CARD_RGB
    return images


def noise(width: int, height: int) -> List[np.ndarray]:
    """Return images in which each channel of each pixel is random: much blue, and red too."""
    random = np.random.RandomState(0)
    return [random.randint(0, 256, (height, width, 3)).astype(np.uint8)
            for _ in range(_FRAMES)]


# each returns images in rgb8, uint8 of shape (height, width, 3)
KINDS = {'film': film, 'noise': noise}
COMMANDS = {'film': 1, 'noise': 2}       # for each image
