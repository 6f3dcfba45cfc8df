"""Noise of a camera's pixels."""
import cv2
import numpy as np

_TABLE_SIZE = 1 << 21       # pixels
_SEED = 0


class PixelNoise:
    """Adds Gaussian noise to images: the same for equal images with equal numbers.

    As in Gazebo, it is one value for the three colors of a pixel.

    The noise is a part of one table, which begins at another place for each image: numpy needs
    20 times as long to make new noise.
    """

    def __init__(self, deviation: float, mean: float = 0.0):
        """Make the table; deviation: the standard deviation of a color, of 0 to 1, like mean."""
        random = np.random.RandomState(_SEED)
        noise = (mean + random.standard_normal(_TABLE_SIZE) * deviation) * 255
        table = np.clip(np.round(noise), -255, 255).astype(np.int16)
        self._table = np.repeat(table[:, np.newaxis], 3, axis=1)

    def add(self, image: np.ndarray, number: int) -> None:
        """Add noise to an image, uint8 of shape (height, width, 3), in place.

        number: of the image; each has another noise.
        """
        flat = image.reshape(-1, 3)
        random = np.random.RandomState(number & 0xffffffff)
        begin = 0
        while begin < len(flat):
            # pieces, so that the noise of a large image does not repeat at a fixed distance
            start = int(random.randint(0, _TABLE_SIZE - 1))
            count = min(len(flat) - begin, _TABLE_SIZE - start)
            piece = flat[begin:begin + count]
            noise = self._table[start:start + count]
            piece[:] = cv2.add(piece, noise, dtype=cv2.CV_8U)
            begin += count
