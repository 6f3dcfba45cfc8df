"""The sky: a color that depends on the height above the horizon."""
import math
from typing import Tuple

import moderngl
import numpy as np

from img_recog.rendering import matrices, shaders
from img_recog.rendering.camera import Pinhole
from img_recog.rendering.shadow_map import whole_image

Rgb = Tuple[float, float, float]        # from 0 to 1


class Sky:
    """Draws the pixels above the horizon."""

    def __init__(self, context: moderngl.Context):
        """Make the program."""
        self._program = context.program(vertex_shader=shaders.SKY_VERTEX,
                                        fragment_shader=shaders.SKY_FRAGMENT)
        self._array = context.vertex_array(self._program, [(whole_image(context), '2f', 'corner')])

    def draw(self, target: moderngl.Framebuffer, camera: Pinhole, view: np.ndarray,
             horizon: Rgb, zenith: Rgb) -> None:
        """Draw it before all else; below the horizon, the pixels must have its color already.

        target: the framebuffer in use, whose first row is the highest; view (4, 4): from the world
        to OpenGL's camera frame.
        """
        left, right, bottom, top = camera.window
        to_ray = np.eye(4)
        # of the corners of the image, x and y from -1 to 1, with z -1
        to_ray[:3, :3] = view[:3, :3].T @ [[(right - left) / 2, 0, -(right + left) / 2],
                                           [0, (bottom - top) / 2, -(bottom + top) / 2],
                                           [0, 0, 1]]
        rectangle = _above_horizon(to_ray, target.size)
        if not all(rectangle[2:]):
            return
        self._program['to_ray'].write(matrices.to_bytes(to_ray))
        self._program['horizon'].value = tuple(horizon)
        self._program['zenith'].value = tuple(zenith)
        target.scissor = rectangle
        self._array.render(moderngl.TRIANGLE_STRIP)
        target.scissor = None


def _above_horizon(to_ray: np.ndarray, size: Tuple[int, int]) -> Tuple[int, int, int, int]:
    """Return x, y, width and height of a rectangle that holds all pixels above the horizon."""
    # the height of a ray is linear in the coordinates of the image, which are from -1 to 1
    by_x, by_y, middle = to_ray[2, 0], to_ray[2, 1], -to_ray[2, 2]
    x, end_x = _positive(by_x, middle + abs(by_y), size[0])
    y, end_y = _positive(by_y, middle + abs(by_x), size[1])
    return x, y, end_x - x, end_y - y


def _positive(slope: float, middle: float, pixels: int) -> Tuple[int, int]:
    """Return the first pixel in which slope * x + middle is positive, and that after the last.

    x is -1 at the begin of the first pixel and 1 at the end of the last one.
    """
    if middle + abs(slope) <= 0:
        return 0, 0
    if middle - abs(slope) >= 0:
        return 0, pixels
    zero = (1 - middle / slope) / 2 * pixels
    # one more, for rounding
    return ((max(0, math.floor(zero) - 1), pixels) if slope > 0
            else (0, min(pixels, math.ceil(zero) + 1)))
