"""The light in which a camera sees: its color temperature, and the exposure."""
from dataclasses import dataclass

import cv2
import numpy as np

from img_recog.settings import Settings, between, setting

_TABLE_SIZE = 1 << 21       # pixels
_SEED = 0
DAYLIGHT_K = 6500.0     # of sRGB's white
# CIE 1931 XYZ to linear sRGB: IEC 61966-2-1
_XYZ_TO_RGB = np.array([[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415],
                        [0.0557, -0.2040, 1.0570]])


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


@dataclass(frozen=True)
class LightSettings(Settings):
    """How a picture differs from one in daylight.

    light_temperature: K, of a black body; a camera without white balance sees 2700, a light bulb,
    as orange. light_exposure: factor of the light that the sensor takes; too much is white.
    """

    light_temperature: float = setting(DAYLIGHT_K, between(1700, 25000))
    light_exposure: float = setting(1.0, between(0.01, 100))


class LightFilter:
    """Changes rgb8 images in daylight into those in another light."""

    def __init__(self, settings: LightSettings):
        gains = settings.light_exposure * gains_of(settings.light_temperature)
        linear = _to_linear(np.arange(256) / 255)
        encoded = _to_srgb(np.clip(linear[:, None] * gains, 0, 1))
        self._table = np.round(encoded * 255).astype(np.uint8).reshape(256, 1, 3)

    def apply(self, image: np.ndarray) -> None:
        """Change an rgb8 image, uint8 of shape (height, width, 3), in place."""
        cv2.LUT(image, self._table, dst=image)


def gains_of(temperature_k: float) -> np.ndarray:
    """Return how much more red, green and blue a white surface sends than in daylight.

    Of equal luminance; in linear sRGB.

    >>> gains_of(2700).round(2).tolist()
    [1.85, 0.82, 0.19]
    """
    white, daylight = _white(temperature_k), _white(DAYLIGHT_K)
    return white / daylight


def _white(temperature_k: float) -> np.ndarray:
    """Return the linear sRGB of a black body with luminance 1.

    The chromaticity is the cubic approximation by Kim et al., US patent 7024034.
    """
    t = 1000 / temperature_k
    if temperature_k <= 4000:
        x = -0.2661239 * t ** 3 - 0.2343589 * t ** 2 + 0.8776956 * t + 0.179910
    else:
        x = -3.0258469 * t ** 3 + 2.1070379 * t ** 2 + 0.2226347 * t + 0.240390
    if temperature_k <= 2222:
        y = -1.1063814 * x ** 3 - 1.34811020 * x ** 2 + 2.18555832 * x - 0.20219683
    elif temperature_k <= 4000:
        y = -0.9549476 * x ** 3 - 1.37418593 * x ** 2 + 2.09137015 * x - 0.16748867
    else:
        y = 3.0817580 * x ** 3 - 5.87338670 * x ** 2 + 3.75112997 * x - 0.37001483
    return np.clip(_XYZ_TO_RGB @ (x / y, 1.0, (1 - x - y) / y), 0.0, None)


def _to_linear(values: np.ndarray) -> np.ndarray:
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def _to_srgb(values: np.ndarray) -> np.ndarray:
    return np.where(values <= 0.0031308, values * 12.92, 1.055 * values ** (1 / 2.4) - 0.055)
