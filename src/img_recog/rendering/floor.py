"""The floor: that of Gazebo's ground_plane."""
import math

import moderngl
import numpy as np

from img_recog.model import Material
from img_recog.rendering import coverage, matrices

_HALF_SIZE_M = 50.0
MATERIAL = Material((0.7, 0.7, 0.7, 1.0), ambient=(0.3, 0.3, 0.3))     # Gazebo/Grey


class Floor:
    """A square at z 0 in the world, whose middle is the origin."""

    def __init__(self, context: moderngl.Context, shaded: moderngl.Program,
                 depth: moderngl.Program, material: int):
        """shaded, depth: the programs; material: the number of MATERIAL in its table."""
        corners = np.insert(_HALF_SIZE_M * coverage.corners(coverage.WHOLE), 2, 0, axis=2)
        whole = context.buffer(corners[:, coverage.TRIANGLES].astype('f4').tobytes())
        same = context.buffer(np.array([0, 0, 1], 'f4').tobytes()
                              + np.array([material], 'u4').tobytes())
        self._shaded = context.vertex_array(shaded, [
            (whole, '3f', 'position'), (same, '3f 1u /r', 'normal', 'material')])
        self._depth = context.vertex_array(depth, [(whole, '3f', 'position')])

    def draw(self) -> None:
        """Draw it."""
        self._shaded.program['model'].write(matrices.to_bytes(np.eye(4)))
        self._shaded.render()

    def draw_depths(self) -> None:
        """Draw its depths."""
        self._depth.render()


def lowest_edge(eye: np.ndarray, far: float) -> float:
    """Return the sine of the angle below the horizon at which it ends in all directions.

    eye (3,): from where it is seen, at most so far; 1 where it is not seen from above.
    """
    x, y, height = eye
    reach = min(_HALF_SIZE_M - max(abs(x), abs(y)), far)
    return height / math.hypot(height, reach) if height > 0 and reach > 0 else 1.0
