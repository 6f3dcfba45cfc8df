"""Draws a scene by OpenGL, in memory: no display is needed."""
import math
from typing import Dict, List, Sequence, Tuple

import cv2
import moderngl
import numpy as np

from img_recog.errors import UserError, one_line
from img_recog.model import Rgb, VisualScene
from img_recog.rendering import coverage, matrices, shaders
from img_recog.rendering.batches import Batch, SceneLoader, lowest_edge
from img_recog.rendering.camera import Pinhole

_MUCH = 0.4 * 4             # of the area of an image; to clear all is faster then
_SAMPLES = 4                # of a pixel, for antialiased edges; the only number of llvmpipe
_END = 0.229        # no sky is seen farther below the horizon
_MAX_CEILING_M = 1e6            # instead of infinity
_FLOOR_TOLERANCE_M = 0.001      # what lies on the floor, at the same height, is seen
_BLOCK_ROWS = 32                # of an image, that the cache of the processor holds
_CLIP_DISTANCE0, _CLIP_DISTANCE1 = 0x3000, 0x3001   # of OpenGL; moderngl has no names for them
# GL_SAMPLE_ALPHA_TO_COVERAGE and _ONE: what is not opaque covers no samples
_CUTOUT = 0x809E, 0x809F


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


class Renderer:
    """Draws images of a scene. To be used in the thread that made it."""

    def __init__(self) -> None:
        """Make the programs; UserError if there is no OpenGL. `load` must come next."""
        self._context = context = _create_context()
        context.front_face = 'cw'       # as images are drawn upside down
        self._loader = SceneLoader(context)
        self._context.enable_direct(_CLIP_DISTANCE0)
        self._clear, self._resolve = (
            context.program(vertex_shader=shaders.WHOLE_VERTEX, fragment_shader=fragment)
            for fragment in (shaders.CLEAR_FRAGMENT, shaders.RESOLVE_FRAGMENT))
        self._sky = Sky(context)
        self._targets: Dict[Tuple[int, int], Target] = {}

    def load(self, scene: VisualScene, poses: np.ndarray) -> List[str]:
        """Draw this scene from now on; return a line for each thing that is left out.

        poses (n, 7): of all parts now; those of parts that do not move stay like that.
        """
        self._surroundings, self._has_floor = scene.surroundings, scene.floor
        with self._context:     # the process may have other contexts
            self._loaded = loaded = self._loader.load(scene, matrices.from_poses(poses))
            self._opaque = [batch for batch in loaded.batches if not batch.is_transparent]
            self._transparent = [batch for batch in loaded.batches if batch.is_transparent]
            self._context.gc()
        self._boxes = coverage.Boxes(loaded.bounds)
        return loaded.missing

    def draw(self, camera: Pinhole, camera_pose: np.ndarray, poses: np.ndarray,
             ceiling: float = math.inf) -> np.ndarray:
        """Return an image, uint8 RGB of shape (height, width, 3).

        camera_pose (4, 4): in the world, of the camera body, which looks along its x axis with z
        upward in the image. poses (n, 7): of all parts, see `matrices.from_poses`. ceiling: the
        height in m from which on nothing is drawn.
        """
        with self._context:
            return self._draw(camera, camera_pose, poses, ceiling)

    def _draw(self, camera: Pinhole, camera_pose: np.ndarray, poses: np.ndarray,
              ceiling: float) -> np.ndarray:
        models, view = matrices.from_poses(poses), matrices.view(camera_pose)
        to_clip = _projection(camera) @ view
        rectangles = coverage.rectangles(self._boxes.in_world(models), to_clip, camera.near)
        is_seen = coverage.are_on_image(rectangles)
        target = self._target(camera.width, camera.height)
        target.pixels.use()
        target.pixels.clear(*self._surroundings.background, 1.0)
        self._set_frame(to_clip, camera_pose[:3, 3], ceiling, models)
        self._draw_background(camera, camera_pose[:3, 3], view)
        if is_seen.any():
            target.begin(coverage.runs(rectangles[is_seen], camera.width, camera.height))
            if ceiling < math.inf:
                self._context.enable_direct(_CLIP_DISTANCE1)
            self._render(self._opaque, models, is_seen)
            # the colors of the samples are multiplied with their opacity already
            self._context.blend_func = (moderngl.SRC_ALPHA, moderngl.ONE_MINUS_SRC_ALPHA,
                                        moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA)
            target.samples.depth_mask = False       # what is behind is seen in any order
            self._render(self._transparent, models, is_seen)
            target.samples.depth_mask = True
            self._context.disable_direct(_CLIP_DISTANCE1)
            target.resolve()
        return target.read()

    def depth(self, camera: Pinhole, camera_pose: np.ndarray, poses: np.ndarray) -> np.ndarray:
        """Return the depths of that image, float32 of shape (height, width).

        A depth is the distance in m along the optical axis, +inf where there is nothing (REP 118).
        """
        with self._context:
            depths = self._encoded_depths(camera, camera_pose, matrices.from_poses(poses))
        for first in range(0, camera.height, _BLOCK_ROWS):
            _decode(depths[first:first + _BLOCK_ROWS], camera)
        return depths

    def _encoded_depths(self, camera: Pinhole, camera_pose: np.ndarray,
                        models: np.ndarray) -> np.ndarray:
        """Return what OpenGL's depth buffer holds, from 0 at `near` to 1 at `far`."""
        target = self._target(camera.width, camera.height)
        target.depths.use()
        target.depths.clear()
        to_clip = _projection(camera) @ matrices.view(camera_pose)
        is_seen = coverage.are_on_image(coverage.rectangles(
            self._boxes.in_world(models), to_clip, camera.near))
        for batch in (*self._opaque, *self._transparent):
            self._context.enable_only(batch.flags)
            self._loader.depth['to_clip'].write(matrices.to_bytes(to_clip @ batch.model(models)))
            batch.render(batch.depth, is_seen)
        if self._has_floor:
            self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
            self._loader.depth['to_clip'].write(matrices.to_bytes(to_clip))
            self._loaded.floor.draw_depths()
        encoded = np.empty((camera.height, camera.width), np.float32)
        target.depths.read_into(encoded, attachment=-1, dtype='f4')
        return encoded

    def _target(self, width: int, height: int) -> Target:
        if (width, height) not in self._targets:
            size = width, height
            self._targets[size] = Target(self._context, size, self._clear, self._resolve)
        return self._targets[width, height]

    def _set_frame(self, to_clip: np.ndarray, eye: np.ndarray, ceiling: float,
                   models: np.ndarray) -> None:
        self._loaded.materials.use(1)
        # on the camera's side of the floor, or all
        kept_heights = ((-1.0 if eye[2] < 0 else 1.0, _FLOOR_TOLERANCE_M) if self._has_floor
                        else (0.0, 1.0))
        for program in self._loaded.programs:
            program['to_clip'].write(matrices.to_bytes(to_clip))
            program['kept_heights'].value = kept_heights
            program['ceiling'].value = min(ceiling, _MAX_CEILING_M)
            program['materials'].value = 1
            if 'eye' in program:
                program['eye'].value = tuple(eye)
        self._loaded.lighting.write(self._loaded.programs, models)

    def _draw_background(self, camera: Pinhole, eye: np.ndarray, view: np.ndarray) -> None:
        """Draw sky and floor, with one sample a pixel: all of their edges are horizontal."""
        self._context.enable_only(moderngl.NOTHING)
        if self._surroundings.has_sky:
            self._sky.draw(camera, view, self._surroundings.background,
                           lowest_edge(eye, camera.far) if self._has_floor else 1.0)
        if self._has_floor:
            self._loaded.floor.draw()

    def _render(self, batches: Sequence[Batch], models: np.ndarray, is_seen: np.ndarray) -> None:
        for batch in batches:
            if not is_seen[batch.boxes].any():
                continue
            batch.shaded.program['model'].write(matrices.to_bytes(batch.model(models)))
            is_cutout = batch.texture is not None and batch.texture.components == 4
            if batch.texture is not None:
                batch.texture.use(0)
            self._context.enable_only(batch.flags)
            for option in _CUTOUT if is_cutout else ():
                self._context.enable_direct(option)
            batch.render(batch.shaded, is_seen)
            for option in _CUTOUT if is_cutout else ():
                self._context.disable_direct(option)


def _decode(depths: np.ndarray, camera: Pinhole) -> None:
    """Replace what a depth buffer holds by distances, see `Renderer.depth`."""
    # from 1 down to 0: in 32 bits, the distances are as exact as the 24 bits that are stored
    remaining = np.subtract(np.float32(1), depths, out=depths)
    is_nothing = remaining <= 0
    remaining *= np.float32(camera.far - camera.near)
    remaining += np.float32(camera.near)
    np.divide(np.float32(camera.far * camera.near), remaining, out=depths)
    depths[is_nothing] = np.inf


def _projection(camera: Pinhole) -> np.ndarray:
    """Return the projection (4, 4), upside down: the first row that is read is the lowest."""
    return np.diag([1.0, -1.0, 1.0, 1.0]) @ matrices.perspective(
        camera.edges, camera.near, camera.far)


def _create_context() -> moderngl.Context:
    try:
        # the names of the runtime libraries; those without a version are in -dev packages
        context = moderngl.create_context(standalone=True, require=330, backend='egl',
                                          libgl='libGL.so.1', libegl='libEGL.so.1')
    except Exception as error:      # of several types
        raise UserError('no OpenGL 3.3 without a display: {}'.format(one_line(error)),
                        'install libegl1 and libgl1-mesa-dri')
    context.gc_mode = 'context_gc'  # not at once, which may be in another context
    return context
