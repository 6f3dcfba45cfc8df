"""Which points the sun reaches: depths of a scene, seen from the sun."""
from typing import List, Optional, Sequence, Tuple

import moderngl
import numpy as np

from img_recog.rendering import matrices, shaders

_SIZE = 2048                # texels
_MIN_RADIUS_M, _MAX_RADIUS_M = 6.0, 30.0
_GRID_M = 5.0               # of the centers that the map may have outside of the static scene
_HALF_DEPTH_M = shaders.SHADOW_DEPTH_M / 2

Sphere = Tuple[np.ndarray, float]       # center (3,) and radius in m
# a vertex array, and its transform (4, 4) to the world
Caster = Tuple[moderngl.VertexArray, np.ndarray]


class ShadowMap:
    """A depth texture of a square region, drawn from the sun.

    What does not move is drawn once for a region; in each frame only the rectangles that hold what
    moves are drawn again.
    """

    def __init__(self, context: moderngl.Context, sun: np.ndarray, program: moderngl.Program):
        """Create the textures.

        sun (3,): the direction to it; program: draws the casters.
        """
        self._context, self._program = context, program
        self._sun_view = matrices.looking(-sun)
        self._kept, self._kept_target = _depth_target(context)
        self.texture, self._target = _depth_target(context)
        self.texture.compare_func = '<='
        copy = context.program(vertex_shader=shaders.WHOLE_VERTEX,
                               fragment_shader=shaders.COPY_DEPTH_FRAGMENT)
        self._copy = context.vertex_array(copy, [(whole_image(context), '2f', 'corner')])
        self._region: Tuple[float, ...] = ()
        self._to_clip = np.eye(4)
        self._drawn: List[Tuple[int, int, int, int]] = []
        self.texel_m = 1.0

    @property
    def to_map(self) -> np.ndarray:
        """The transform (4, 4) from the world to the texture: 0 to 1, and the depth."""
        halves = np.diag([0.5, 0.5, 0.5, 1.0])
        halves[:3, 3] = 0.5
        return halves @ self._to_clip

    def draw(self, static_casters: Sequence[Caster], static: Optional[Sphere],
             moving_casters: Sequence[Caster], moving: Sequence[Sphere]) -> None:
        """Draw the depths; `static` and `moving` hold all that does not and does move."""
        self._context.enable_only(moderngl.DEPTH_TEST)
        region = _region(static, moving)
        if region != self._region:
            self._region = region
            self._set_region(np.array(region[:3]), region[3])
            self._kept_target.use()
            self._kept_target.clear(depth=1.0)
            self._render(static_casters)
            self._restore([(0, 0, _SIZE, _SIZE)])
        else:
            self._restore(self._drawn)
        self._target.use()
        self._render(moving_casters)
        self._drawn = [self._rectangle(*sphere) for sphere in moving]

    def _set_region(self, center: np.ndarray, radius_m: float) -> None:
        self.texel_m = 2 * radius_m / _SIZE
        view = self._sun_view.copy()
        view[:3, 3] = -self._sun_view[:3, :3] @ center
        projection = matrices.orthographic(radius_m, radius_m, -_HALF_DEPTH_M, _HALF_DEPTH_M)
        self._to_clip = projection @ view

    def _render(self, casters: Sequence[Caster]) -> None:
        for array, model in casters:
            self._program['to_clip'].write(matrices.to_bytes(self._to_clip @ model))
            array.render()

    def _restore(self, rectangles: Sequence[Tuple[int, int, int, int]]) -> None:
        """Copy the static depths of the rectangles."""
        self._context.depth_func = '1'
        self._target.use()
        self._kept.use(0)
        for rectangle in rectangles:
            self._target.scissor = rectangle
            self._copy.render(moderngl.TRIANGLE_STRIP)
        self._target.scissor = None
        self._context.depth_func = '<'

    def _rectangle(self, center: np.ndarray, radius_m: float) -> Tuple[int, int, int, int]:
        """Return x, y, width and height of the texels that hold a sphere."""
        middle = (self.to_map @ (*center, 1.0))[:2] * _SIZE
        reach = radius_m / self.texel_m + 2
        low = np.clip(np.floor(middle - reach), 0, _SIZE).astype(int)
        high = np.clip(np.ceil(middle + reach), 0, _SIZE).astype(int)
        return (int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1]))


def _region(static: Optional[Sphere], moving: Sequence[Sphere]) -> Tuple[float, ...]:
    """Return the center and the radius of a sphere to be mapped.

    It depends on nothing else: the same poses must give the same image. It is that of the static
    scene, or of the first one that moves if that is outside.
    """
    center, radius_m = static or (np.zeros(3), 0.0)
    radius_m = min(max(radius_m, _MIN_RADIUS_M), _MAX_RADIUS_M)
    if moving:
        first, size_m = moving[0]
        if np.linalg.norm(first - center) + size_m > radius_m:
            center = np.round(first / _GRID_M) * _GRID_M
    return (*map(float, center), float(radius_m))


def _depth_target(context: moderngl.Context) -> Tuple[moderngl.Texture, moderngl.Framebuffer]:
    texture = context.depth_texture((_SIZE, _SIZE))
    texture.compare_func = ''
    texture.filter = moderngl.NEAREST, moderngl.NEAREST
    texture.repeat_x = texture.repeat_y = False
    return texture, context.framebuffer(depth_attachment=texture)


def whole_image(context: moderngl.Context) -> moderngl.Buffer:
    """Return the corners of a strip that covers an image."""
    return context.buffer(np.array([-1, -1, 1, -1, -1, 1, 1, 1], 'f4').tobytes())
