"""The floor: one color, but for the shadows on it."""
import moderngl
import numpy as np

from img_recog.rendering import coverage, shaders
from img_recog.rendering.shadow_map import MAX_TEXELS

_HALF_SIZE_M = 200.0
WHOLE = np.insert(_HALF_SIZE_M * coverage.corners(coverage.WHOLE), 2, 0, axis=2)
_GRAY = 178 / 255
_NORMAL_AND_COLOR = np.array([0, 0, 1, _GRAY, _GRAY, _GRAY, 1], 'f4')
_MAX_SHADOWED = coverage.count_tiles(MAX_TEXELS, MAX_TEXELS)


class Floor:
    """A square at z 0 in the world, whose middle is the origin.

    lit: the program for what is in no shadow: to look shadows up takes three times as long.
    """

    def __init__(self, context: moderngl.Context, shaded: moderngl.Program,
                 depth: moderngl.Program):
        """shaded: the program for what can be in a shadow; depth: draws depths alone."""
        self.lit = context.program(vertex_shader=shaders.LIT_FLOOR_VERTEX,
                                   fragment_shader=shaders.FLAT_FRAGMENT)
        whole = context.buffer(_triangles(WHOLE))
        same = context.buffer(_NORMAL_AND_COLOR.tobytes())
        self._shadowed = context.buffer(reserve=whole.size * _MAX_SHADOWED, dynamic=True)
        self._lit = context.vertex_array(self.lit, [
            (whole, '3f', 'position'), (same, '12x 4f /r', 'color')])
        self._shaded = context.vertex_array(shaded, [
            (self._shadowed, '3f', 'position'), (same, '3f 4f /r', 'normal', 'color')])
        self._depth = context.vertex_array(depth, [(whole, '3f', 'position')])

    def draw(self, shadowed: np.ndarray) -> None:
        """Draw it; shadowed (k, 4, 3): the corners of parallelograms that hold all shadows.

        With WHOLE, they can be everywhere.
        """
        if shadowed is not WHOLE:
            self._lit.render()
        if len(shadowed):
            self._shadowed.write(_triangles(shadowed))
            self._shaded.render(vertices=6 * len(shadowed))

    def draw_depths(self) -> None:
        """Draw its depths."""
        self._depth.render()


def _triangles(parallelograms: np.ndarray) -> bytes:
    return parallelograms[:, coverage.TRIANGLES].astype('f4').tobytes()
