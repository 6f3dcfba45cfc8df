"""Framebuffers of the size of an image."""
from typing import Tuple

import cv2
import moderngl
import numpy as np

from img_recog.rendering import coverage

_MUCH = 0.4 * 4             # of the area of an image; to clear all is faster then
_SAMPLES = 4                # of a pixel, for antialiased edges; the only number of llvmpipe


class Target:
    """Framebuffers of one size.

    samples: of what is antialiased, transparent elsewhere; pixels: the image; depths: for `depth`.
    """

    def __init__(self, context: moderngl.Context, size: Tuple[int, int],
                 clear: moderngl.Program, resolve: moderngl.Program):
        self._texture = context.texture(size, 4, samples=_SAMPLES)
        self.samples = context.framebuffer(
            self._texture, context.depth_renderbuffer(size, samples=_SAMPLES))
        self.pixels = context.framebuffer(context.renderbuffer(size, 4))
        self.depths = context.framebuffer(depth_attachment=context.depth_texture(size))
        self._rgba = np.empty((size[1], size[0], 4), np.uint8)
        self._tiles = context.buffer(reserve=48 * coverage.count_tiles(*size), dynamic=True)
        self._count, self._area = 0, 0.0
        self._clear, self._resolve = (
            context.vertex_array(program, [(self._tiles, '2f', 'corner')])
            for program in (clear, resolve))
        self._context = context
        self.samples.clear()

    def begin(self, rectangles: np.ndarray) -> None:
        """Use the samples for what is in rectangles (k, 4), from -1 to 1: no two overlap."""
        self.samples.use()
        self._tiles.write(coverage.triangles(rectangles))
        self._count = len(rectangles)
        self._area = np.prod(rectangles[:, 2:] - rectangles[:, :2], axis=1).sum()

    def resolve(self) -> None:
        """Draw the average of the samples of each pixel over the image, in those rectangles."""
        self._context.enable_only(moderngl.BLEND)
        self._context.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        self.pixels.use()
        self._texture.use(0)
        self._resolve.render(moderngl.TRIANGLES, vertices=6 * self._count)

    def read(self) -> np.ndarray:
        """Return the image, uint8 RGB."""
        # in four bytes a pixel, as they are stored: OpenGL converts slowly
        self.pixels.read_into(self._rgba, components=4)
        if self._count:
            self._clear_samples()
        return cv2.cvtColor(self._rgba, cv2.COLOR_RGBA2RGB)

    def _clear_samples(self) -> None:
        """Clear what was drawn, for the next image: OpenGL does it while this one is sent."""
        self.samples.use()
        if self._area > _MUCH:
            self.samples.clear()
        else:
            self._context.enable_only(moderngl.DEPTH_TEST)
            self._context.depth_func = '1'
            self._clear.render(moderngl.TRIANGLES, vertices=6 * self._count)
            self._context.depth_func = '<'
        self._count = 0
        self.pixels.use()
        self.pixels.clear()         # OpenGL begins to clear the samples
