"""What a scene is loaded into: triangles in the memory of OpenGL, in batches."""
import math
from functools import partial
from typing import Dict, List, NamedTuple, Optional, Sequence, Tuple

import moderngl
import numpy as np

from img_recog.errors import one_line
from img_recog.formats import materials
from img_recog.formats.meshes.mesh_file import MeshError, Triangles
from img_recog.model import (DIRECTIONAL, EXP, EXP2, LINEAR, MESH, SPOT, WHITE, Fog, Light,
                             Material, Rgb, Shape, Surroundings, Visual, VisualScene)
from img_recog.rendering import coverage, matrices, prepared, shaders, triangles
from img_recog.rendering.prepared import FileCache
from img_recog.rendering.shaders import MAX_LIGHTS

_HALF_SIZE_M = 50.0
MATERIAL = Material((0.7, 0.7, 0.7, 1.0), ambient=(0.3, 0.3, 0.3))     # Gazebo/Grey
_STEEP = 1e6            # the slope of the edge of a cone that is sharp
_EVERYWHERE = -2.0, 1.0, 0.0        # a cone of a light without one
_EXPONENTS = {LINEAR: 0.0, EXP: 1.0, EXP2: 2.0}
_NO_TEXTURE = -1
_VERTEX = np.dtype([('position', 'f4', 3), ('normal', 'f4', 3), ('uv', 'f4', 2),
                    ('material', 'u4')])

# what the triangles of a batch have in common: transparent, part or -1, texture or -1, shining
_Key = Tuple[bool, int, int, bool]


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


class Lighting:
    """Writes lights and fog to programs.

    are_directions: whether all lights are directional; have_highlights: whether some are seen in
    what shines; problem: a line if there are more than can be drawn, else ''.
    """

    def __init__(self, lights: Sequence[Tuple[int, Light]], surroundings: Surroundings):
        """lights: each with the number of its part, -1 for the world."""
        self.problem = '' if len(lights) <= MAX_LIGHTS else (
            '{} of {} lights'.format(len(lights) - MAX_LIGHTS, len(lights)))
        lights = lights[:MAX_LIGHTS]
        self._parts = np.array([part for part, _ in lights], int)
        self._lights = [light for _, light in lights]
        self._surroundings = surroundings
        self.are_directions = all(light.kind == DIRECTIONAL for light in self._lights)
        self.have_highlights = any(max(light.specular) > 0 for light in self._lights)
        self._poses = np.array([light.pose.matrix() for light in self._lights]).reshape(-1, 4, 4)
        directions = np.array([light.direction for light in self._lights]).reshape(-1, 3)
        self._directions = directions / np.linalg.norm(directions, axis=1, keepdims=True)
        self._constant = {
            'lamp': [light.diffuse for light in self._lights],
            'lamp_specular': [light.specular for light in self._lights],
            'fading': [(*light.attenuation, light.reach) for light in self._lights],
            'cone': [_cone(light) for light in self._lights]}

    def write(self, programs: Sequence[moderngl.Program], models: np.ndarray) -> None:
        """Write all; models (n, 4, 4): the transforms of the parts to the world."""
        poses = matrices.of_parts(models, self._parts) @ self._poses
        axes = (poses[:, :3, :3] @ self._directions[..., np.newaxis])[..., 0]
        is_direction = np.array([light.kind == DIRECTIONAL for light in self._lights], bool)
        places = np.where(is_direction[:, np.newaxis], -axes, poses[:, :3, 3])
        values = {**self._constant, 'axis': axes,
                  'place': np.column_stack([places, ~is_direction])}
        for program in programs:
            if 'light_count' in program:
                program['light_count'].value = len(self._lights)
            for name, rows in values.items():
                if name in program and len(rows):
                    array = np.zeros((MAX_LIGHTS, np.shape(rows)[1]), 'f4')
                    array[:len(rows)] = rows
                    program[name].write(array.tobytes())
            if self._surroundings.fog is not None:
                program['fog'].value = _numbers(self._surroundings.fog)
                program['fog_color'].value = self._surroundings.fog.color


def _cone(light: Light) -> Tuple[float, float, float]:
    """Return the cosine at the edge, the slope from there inward, and the exponent."""
    if light.kind != SPOT:
        return _EVERYWHERE
    bright, dark = (math.cos(angle / 2) for angle in light.cone[:2])
    return dark, 1 / (bright - dark) if bright - dark > 1 / _STEEP else _STEEP, light.cone[2]


def _numbers(fog: Fog) -> Tuple[float, float, float, float]:
    length = fog.end - fog.start
    return (fog.end, 1 / length if length else _STEEP, fog.density, _EXPONENTS[fog.kind])


class Batch(NamedTuple):
    """Triangles that are drawn alike: of one texture, and of one moving part or all static ones.

    They are those of some visuals, one after the other. part: the number of the moving part, -1
    for static ones; boxes (k,): the numbers of the visuals' bounds; ends (k + 1,): the corners
    before each visual, and all; texture: None for none, with an alpha channel
    if the triangles are only seen where it is opaque; flags: what moderngl's `enable_only` gets;
    shaded, depth: drawn by the programs of those names.
    """

    part: int
    boxes: np.ndarray
    ends: np.ndarray
    texture: Optional[moderngl.Texture]
    is_transparent: bool
    flags: int
    shaded: moderngl.VertexArray
    depth: moderngl.VertexArray

    def model(self, models: np.ndarray) -> np.ndarray:
        """Return its transform (4, 4) to the world; models (n, 4, 4): those of all parts."""
        return models[self.part] if self.part >= 0 else np.eye(4)

    def render(self, array: moderngl.VertexArray, is_seen: np.ndarray) -> None:
        """Draw what is seen; array: `shaded` or `depth`; is_seen (n,): of the bounds of all."""
        changes = np.diff(is_seen[self.boxes], prepend=False, append=False)
        for begin, end in self.ends[changes].reshape(-1, 2).tolist():
            array.render(vertices=end - begin, first=begin)


class Bounds(NamedTuple):
    """The lowest and highest x, y and z (3,) of triangles, in the frame of their part.

    part: the number of the moving part, -1 for static triangles, in the frame of the world.
    """

    part: int
    low: np.ndarray
    high: np.ndarray


class Loaded(NamedTuple):
    """A scene in the memory of OpenGL.

    bounds: of each visual; programs: that draw it; materials: the table of them all, which the
    programs look up; missing: a line for each mesh, texture or light that is left out.
    """

    batches: List[Batch]
    bounds: List[Bounds]
    floor: Floor
    lighting: Lighting
    programs: List[moderngl.Program]
    materials: moderngl.Texture
    missing: List[str]


class SceneLoader:
    """Loads scenes, and keeps the textures of all.

    depth: the program that draws depths; to_clip is its uniform.
    """

    def __init__(self, context: moderngl.Context):
        """context: in which all is loaded."""
        self._context = context
        self._programs: Dict[Tuple[str, ...], moderngl.Program] = {}
        self.depth = context.program(vertex_shader=shaders.DEPTH_VERTEX,
                                     fragment_shader=shaders.DEPTH_FRAGMENT)
        self._meshes = FileCache(prepared.read_mesh)
        self._images = FileCache(prepared.read_texture)
        self._cutouts = FileCache(partial(prepared.read_texture, mode='RGBA'))
        # by the id of their image, which therefore is kept
        self._textures: Dict[int, Tuple[np.ndarray, moderngl.Texture]] = {}
        self._missing: List[str] = []

    def load(self, scene: VisualScene, models: np.ndarray) -> Loaded:
        """Load a scene; models (n, 4, 4): the transforms of all parts to the world."""
        self._missing = []
        old_textures, self._textures = self._textures, {}
        self._lighting = Lighting(scene.lights, scene.surroundings)
        self._miss(self._lighting.problem)
        self._surroundings = scene.surroundings
        self._materials: Dict[Material, int] = {}
        bounds: List[Bounds] = []
        grouped: Dict[_Key, List[Tuple[int, np.ndarray]]] = {}
        for visual in scene.visuals:
            is_moving = scene.moving[visual.part]
            pose = visual.pose if is_moving else models[visual.part] @ visual.pose
            part = visual.part if is_moving else -1
            for corners, image, material in self._vertices(visual, pose):
                key = (material.color[3] < 1, part, self._texture(image, old_textures),
                       self._shines(material) or _bends(corners))
                grouped.setdefault(key, []).append((len(bounds), corners))
                bounds.append(Bounds(part, corners['position'].min(axis=0),
                                     corners['position'].max(axis=0)))
        self._meshes.forget_unused()
        self._images.forget_unused()
        self._cutouts.forget_unused()
        # in this order, whatever the textures are in the memory: of what is at the same place, the
        # first is seen
        keys = sorted(grouped, key=lambda key: (key[:2], key[2] != _NO_TEXTURE, key[3]))
        batches = [self._batch(key, *zip(*grouped[key])) for key in keys]
        ground = Floor(self._context, self._program(), self.depth,
                       self._number(MATERIAL))
        programs = {id(each): each for each in (
            self._program(), *(batch.shaded.program for batch in batches))}
        return Loaded(batches, bounds, ground, self._lighting, list(programs.values()),
                      self._table(scene.surroundings.ambient), self._missing)

    def _shines(self, material: Material) -> bool:
        """Return whether a material may have a highlight."""
        return (self._lighting.have_highlights and material.shininess > 0
                and max(material.specular) > 0)

    def _program(self, is_textured: bool = False, by_pixels: bool = False) -> moderngl.Program:
        options = (*(('TEXTURED',) if is_textured else ()),
                   *(() if self._lighting.are_directions and not by_pixels else ('PIXELS',)),
                   *(('FOG',) if self._surroundings.fog is not None else ()))
        if options not in self._programs:
            self._programs[options] = self._context.program(**shaders.shaded(*options))
        return self._programs[options]

    def _number(self, material: Material) -> int:
        """Return the number that a material has in the table."""
        return self._materials.setdefault(material, len(self._materials))

    def _table(self, ambient: Rgb) -> moderngl.Texture:
        """Return the table of the materials in some ambient light."""
        height = len(self._materials) // shaders.TABLE_WIDTH + 1
        table = np.zeros((height, 3, shaders.TABLE_WIDTH, 4), 'f4')
        for material, number in self._materials.items():
            row, column = divmod(number, shaders.TABLE_WIDTH)
            red, green, blue, opacity = material.color
            base = np.array(material.ambient or (red, green, blue)) * ambient + material.emissive
            table[row, :, column] = ((*base, opacity), (red, green, blue, material.shininess),
                                     (*material.specular, 0) if self._shines(material)
                                     else (0, 0, 0, 0))
        texture = self._context.texture((shaders.TABLE_WIDTH, 3 * height), 4, table.tobytes(),
                                        dtype='f4')
        texture.filter = moderngl.NEAREST, moderngl.NEAREST
        return texture

    def _vertices(self, visual: Visual, pose: np.ndarray
                  ) -> List[Tuple[np.ndarray, Optional[np.ndarray], Material]]:
        """Return corners, image and material of each part that is seen."""
        found = []
        for part in self._triangles(visual.shape):
            material = _material(visual, part)
            if material.color[3] > 0:
                image = self._image(material.texture, self._cutouts if material.is_cutout
                                    else self._images)
                found.append((_corners(part, pose, self._number(material), material.scale),
                              image, material))
        return found

    def _triangles(self, shape: Shape) -> List[Triangles]:
        try:
            parts = triangles.of_shape(shape, self._meshes.get)
        except MeshError as error:
            self._miss(one_line(error))
            return []
        for part in parts:
            self._miss(part.problem)
        return parts

    def _image(self, path: str, images: FileCache[np.ndarray]) -> Optional[np.ndarray]:
        """Return the image at a path, None for '' or if it cannot be read."""
        try:
            return images.get(path) if path else None
        except materials.TextureError as error:
            self._miss(one_line(error))
            return None

    def _miss(self, problem: str) -> None:
        if problem and problem not in self._missing:
            self._missing.append(problem)

    def _batch(self, key: _Key, boxes: Sequence[int], corners: Sequence[np.ndarray]) -> Batch:
        is_transparent, part, texture, by_pixels = key
        image = self._textures[texture][1] if texture != _NO_TEXTURE else None
        flags = moderngl.DEPTH_TEST
        if is_transparent:
            flags |= moderngl.BLEND
        if image is None or image.components == 3:
            flags |= moderngl.CULL_FACE     # like in Gazebo; leaves that are cut out have no back
        buffer = self._context.buffer(np.concatenate(corners))
        program = self._program(image is not None, by_pixels)
        shaded = self._context.vertex_array(program, [
            (buffer, '3f 3f 8x 1u', 'position', 'normal', 'material') if image is None else
            (buffer, '3f 3f 2f 1u', 'position', 'normal', 'uv', 'material')])
        depth = self._context.vertex_array(self.depth, [(buffer, '3f 24x', 'position')])
        ends = np.cumsum([0, *map(len, corners)])
        return Batch(part, np.array(boxes, int), ends, image, is_transparent, flags, shaded, depth)

    def _texture(self, image: Optional[np.ndarray],
                 old: Dict[int, Tuple[np.ndarray, moderngl.Texture]]) -> int:
        """Return the key of an image in `_textures`; old: those of the last scene."""
        if image is None:
            return _NO_TEXTURE
        key = id(image)
        if key in old:
            self._textures[key] = old[key]
        if key not in self._textures:
            height, width, channels = image.shape
            # OpenGL's first row is the lowest
            texture = self._context.texture((width, height), channels,
                                            np.ascontiguousarray(image[::-1]))
            texture.build_mipmaps()
            texture.filter = moderngl.LINEAR_MIPMAP_LINEAR, moderngl.LINEAR
            self._textures[key] = image, texture
        return key


def _material(visual: Visual, part: Triangles) -> Material:
    """Return the material of triangles: that of the visual, or that of the file."""
    given = visual.material
    if given is not None and not (visual.prefers_file and part.has_material):
        return given
    return (part.material if visual.shape.kind == MESH else WHITE).faded(visual.opacity)


def _bends(corners: np.ndarray) -> bool:
    """Return whether normals of a triangle differ by 60 degrees: pixels are lit then.

    Gazebo lights all pixels. For smaller angles, a mixture of the light at the corners is near it.
    """
    normals = corners['normal'].reshape(-1, 3, 3)
    return bool(((normals * np.roll(normals, 1, axis=1)).sum(axis=2) < 0.5).any())


def _corners(part: Triangles, pose: np.ndarray, material: int,
             scale: Sequence[float] = (1.0, 1.0)) -> np.ndarray:
    """Return the corners of triangles, moved by `pose` (4, 4), as an array of _VERTEX.

    material: its number; scale: of the texture, about its middle, like Ogre does it.
    """
    corners = np.empty(len(part.positions) * 3, _VERTEX)
    corners['position'] = part.positions.reshape(-1, 3) @ pose[:3, :3].T + pose[:3, 3]
    corners['normal'] = part.normals.reshape(-1, 3) @ pose[:3, :3].T
    corners['uv'] = (part.uvs.reshape(-1, 2) - 0.5) / scale + 0.5
    corners['material'] = material
    return corners
