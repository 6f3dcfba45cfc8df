"""The sky: a color that depends on the direction."""
import moderngl
import numpy as np

from img_recog.model import Rgb
from img_recog.rendering import coverage, matrices, shaders
from img_recog.rendering.camera import Pinhole

_END = 0.229        # no sky is seen farther below the horizon


class Sky:
    """Draws the pixels above the horizon, and the haze below it."""

    def __init__(self, context: moderngl.Context):
        """Make the program."""
        self._program = context.program(vertex_shader=shaders.SKY_VERTEX,
                                        fragment_shader=shaders.SKY_FRAGMENT)
        corners = context.buffer(coverage.triangles(coverage.WHOLE))
        self._array = context.vertex_array(self._program, [(corners, '2f', 'corner')])

    def draw(self, camera: Pinhole, view: np.ndarray, background: Rgb, lowest: float) -> None:
        """Draw it before all else, no farther below the horizon than at an angle with this sine.

        It is clipped by CLIP_DISTANCE0. view (4, 4): from the world to OpenGL's camera frame; the
        first row of the image is the highest. background: into which it fades below the horizon.
        """
        left, right, bottom, top = camera.edges
        to_ray = np.eye(4)
        # of the corners of the image, x and y from -1 to 1, with z -1
        to_ray[:3, :3] = view[:3, :3].T @ [[(right - left) / 2, 0, -(right + left) / 2],
                                           [0, (bottom - top) / 2, -(bottom + top) / 2],
                                           [0, 0, 1]]
        self._program['to_ray'].write(matrices.to_bytes(to_ray))
        self._program['background'].value = tuple(background)
        self._program['lowest'].value = min(lowest, _END)
        self._array.render()
