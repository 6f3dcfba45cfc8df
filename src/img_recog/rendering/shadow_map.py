"""Which points the sun reaches: depths of a scene, seen from the sun."""
import itertools
from typing import List, Sequence, Tuple

import moderngl
import numpy as np

from img_recog.rendering import coverage, matrices, shaders
from img_recog.rendering.batches import Batch, Bounds

MAX_TEXELS = 2048           # of a side
_TEXEL_M = 0.007
_WIDE_TEXEL_M = 0.015
_MARGIN_TEXELS = 2          # around what a part can shadow
_MIN_HALF_M, _MAX_HALF_M = 4.0, 30.0
_GRID_M = 4.0               # of the centers that the map may have outside of the static scene
# Of a transform: bodies that rest still move by micrometers. It is rounded, not compared with a
# tolerance, as the same poses must give the same image.
_DECIMALS = 4
_HALF_DEPTH_M = shaders.SHADOW_DEPTH_M / 2

Rectangle = Tuple[int, int, int, int]   # x, y, width and height in texels


class ShadowMap:
    """A depth texture of a rectangular region, drawn from the sun.

    What has not moved yet is drawn once for a region. In each frame, `restore` restores the
    rectangles that held parts that did move, and `add` draws those whose shadows are seen.
    """

    def __init__(self, context: moderngl.Context, sun: np.ndarray, program: moderngl.Program,
                 batches: Sequence[Batch], bounds: Sequence[Bounds]):
        """Create the textures.

        sun (3,): the direction to it; program: draws the batches; bounds: of all that is drawn.
        """
        self._context, self._program, self._batches = context, program, batches
        self._spheres = _Spheres(bounds)
        self._sun_view = matrices.looking(-sun)
        self._center, self._halves_m = _region(bounds, self._sun_view[:2, :3])
        # not larger than needed: what does not fit into the cache of the processor is slow
        size = np.minimum(np.ceil(2 * self._halves_m / _TEXEL_M), MAX_TEXELS).astype(int)
        self._size = int(size[0]), int(size[1])
        self._texels_m = 2 * self._halves_m / size      # in x and y of the map
        self._kept, self._kept_target = _depth_target(context, self._size)
        self.texture, self._target = _depth_target(context, self._size)
        self.texture.compare_func = '<='
        copy = context.program(vertex_shader=shaders.WHOLE_VERTEX,
                               fragment_shader=shaders.COPY_DEPTH_FRAGMENT)
        self._copy = context.vertex_array(copy, [(whole_image(context), '2f', 'corner')])
        self._first = np.empty((0, 4, 4))
        self._moved = np.empty(0, bool)     # parts; the last one is the world, which never moves
        self._to_clip = np.eye(4)
        self._models, self._centers = self._first, np.empty((0, 3))
        self._added = self._moved
        self._drawn: List[Rectangle] = []

    @property
    def texel_m(self) -> float:
        """The longer side of a texel, in m."""
        return float(self._texels_m.max())

    @property
    def grazing(self) -> float:
        """The cosine between a face's normal and the sun below which it is not lit.

        The bias against its own shadow ends at 0.1, and is too small from half of that on: in a
        large world, whose texels are wide, such faces had stripes.
        """
        return 0.0 if self.texel_m < _WIDE_TEXEL_M else 0.05

    @property
    def to_map(self) -> np.ndarray:
        """The transform (4, 4) from the world to the texture: 0 to 1, and the depth."""
        halves = np.diag([0.5, 0.5, 0.5, 1.0])
        halves[:3, 3] = 0.5
        return halves @ self._to_clip

    def restore(self, models: np.ndarray) -> None:
        """Make it that of what has not moved; models (n, 4, 4): transforms of all parts."""
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._models = models = models.round(_DECIMALS)
        self._centers = self._spheres.centers(models)
        to_clip = self._region_to_clip(self._centers)
        if self._note_moved(models) or (to_clip != self._to_clip).any():
            self._to_clip = to_clip
            self._kept_target.use()
            self._kept_target.clear()
            self._render(~self._moved)
            self._copy_kept([(0, 0, *self._size)])
        elif self._drawn:
            self._copy_kept(self._drawn)
        self._added, self._drawn = np.zeros_like(self._moved), []

    def add(self, parts: np.ndarray) -> None:
        """Draw those of some parts (k,), -1 for the world, that are not in it yet."""
        is_new = np.zeros_like(self._moved)
        is_new[parts] = True
        is_new &= self._moved & ~self._added
        if is_new.any():
            self._context.enable_only(moderngl.DEPTH_TEST)
            self._target.use()
            self._render(is_new)
            self._added |= is_new
            drawn = is_new[self._spheres.parts]
            self._drawn += self._rectangles(self._centers[drawn], self._spheres.radii[drawn])

    def reached(self, boxes: np.ndarray) -> np.ndarray:
        """Return the rectangles (n, 4) of the map that the shadows of boxes can reach.

        boxes (n, 8, 3): their corners in the world; the result is from -1 to 1 on the map: lowest
        x, y and highest x, y.
        """
        places = boxes @ self._to_clip[:2, :3].T + self._to_clip[:2, 3]
        margin = np.array([2 * _MARGIN_TEXELS]) / self._size
        return np.concatenate([places.min(axis=1) - margin, places.max(axis=1) + margin], axis=1)

    def on_floor(self, rectangles: np.ndarray) -> np.ndarray:
        """Return the corners (n, 4, 3) of parallelograms at z 0, that rectangles (n, 4) hold."""
        (a, b), (c, d) = self._to_clip[:2, :2]
        places = coverage.corners(rectangles) - self._to_clip[:2, 3]
        return np.insert(places @ np.array([[d, -c], [-b, a]]) / (a * d - b * c), 2, 0, axis=2)

    def tiles(self, rectangles: np.ndarray) -> np.ndarray:
        """Return rectangles (k, 4) of which no two overlap, and that hold others (n, 4)."""
        return coverage.runs(rectangles[coverage.are_on_image(rectangles)], *self._size)

    def _note_moved(self, models: np.ndarray) -> bool:
        """Return whether a part moved that never did before."""
        if len(self._first) != len(models):
            self._first, self._moved = models, np.zeros(len(models) + 1, bool)
        moved = self._moved.copy()
        moved[:-1] |= (models != self._first).any(axis=(1, 2))
        is_new = bool((moved != self._moved).any())
        self._moved = moved
        return is_new

    def _region_to_clip(self, centers: np.ndarray) -> np.ndarray:
        """Return the projection (4, 4) of the region; centers (k, 3): of the spheres.

        It depends on nothing else: the same poses must give the same image. It is around what
        cannot move, or near the first part that can if that is outside.
        """
        center = self._center
        can_move = self._spheres.parts >= 0
        for first, radius_m in zip(centers[can_move][:1], self._spheres.radii[can_move]):
            aside = np.abs(self._sun_view[:2, :3] @ (first - center))
            if (aside + radius_m > self._halves_m).any():
                center = np.round(first / _GRID_M) * _GRID_M
        view = self._sun_view.copy()
        view[:3, 3] = -self._sun_view[:3, :3] @ center
        half_x, half_y = self._halves_m
        return matrices.orthographic(half_x, half_y, -_HALF_DEPTH_M, _HALF_DEPTH_M) @ view

    def _render(self, which: np.ndarray) -> None:
        """Draw the batches of parts; which (n + 1,): of all, and the world."""
        for batch in self._batches:
            if which[batch.part]:
                self._program['to_clip'].write(
                    matrices.to_bytes(self._to_clip @ batch.model(self._models)))
                batch.depth.render()

    def _copy_kept(self, rectangles: Sequence[Rectangle]) -> None:
        """Copy the kept depths of the rectangles."""
        self._context.depth_func = '1'
        self._target.use()
        self._kept.use(0)
        for rectangle in rectangles:
            self._target.scissor = rectangle
            self._copy.render()
        self._target.scissor = None
        self._context.depth_func = '<'

    def _rectangles(self, centers: np.ndarray, radii: np.ndarray) -> List[Rectangle]:
        """Return the texels that hold spheres (k, 3) and (k,)."""
        middles = (centers @ self.to_map[:2, :3].T + self.to_map[:2, 3]) * self._size
        reaches = radii[:, np.newaxis] / self._texels_m + 2
        low = np.floor(middles - reaches).clip(0, self._size).astype(int)
        sizes = np.ceil(middles + reaches).clip(0, self._size).astype(int) - low
        return [(x, y, width, height)
                for (x, y), (width, height) in zip(low.tolist(), sizes.tolist())]


class _Spheres:
    """A sphere around each part and one around all that cannot move.

    parts (k,): their numbers, -1 for what cannot move; radii (k,): m.
    """

    def __init__(self, bounds: Sequence[Bounds]):
        self.parts = np.unique(np.array([each.part for each in bounds], int))
        boxes = [[each for each in bounds if each.part == part] for part in self.parts]
        low = np.array([np.min([each.low for each in box], axis=0) for box in boxes])
        high = np.array([np.max([each.high for each in box], axis=0) for box in boxes])
        self._middles = ((low + high) / 2).reshape(-1, 3)
        self.radii = np.linalg.norm((high - low).reshape(-1, 3), axis=1) / 2

    def centers(self, models: np.ndarray) -> np.ndarray:
        """Return the centers (k, 3) in the world; models (n, 4, 4): transforms of the parts."""
        moved = matrices.of_parts(models, self.parts)
        return (moved[:, :3, :3] @ self._middles[..., np.newaxis])[..., 0] + moved[:, :3, 3]


def _region(bounds: Sequence[Bounds], across: np.ndarray) -> Tuple[np.ndarray, np.ndarray]:
    """Return the center (3,) and half the size (2,) of what cannot move, seen from the sun, in m.

    across (2, 3): the axes of the image of the sun.
    """
    corners = np.array([[x, y, z] for each in bounds if each.part < 0
                        for x, y, z in itertools.product(*zip(each.low, each.high))])
    if not len(corners):
        return np.zeros(3), np.full(2, _MIN_HALF_M)
    places = corners @ across.T
    low, high = places.min(axis=0), places.max(axis=0)
    return (low + high) / 2 @ across, ((high - low) / 2).clip(_MIN_HALF_M, _MAX_HALF_M)


def _depth_target(context: moderngl.Context, size: Tuple[int, int]
                  ) -> Tuple[moderngl.Texture, moderngl.Framebuffer]:
    texture = context.depth_texture(size)
    texture.compare_func = ''
    texture.filter = moderngl.NEAREST, moderngl.NEAREST
    texture.repeat_x = texture.repeat_y = False
    return texture, context.framebuffer(depth_attachment=texture)


def whole_image(context: moderngl.Context) -> moderngl.Buffer:
    """Return the corners of two triangles that cover an image."""
    return context.buffer(coverage.triangles(coverage.WHOLE))
