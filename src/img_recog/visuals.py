"""What there is to draw: plain values that the simulation gives, and that are rendered."""
from typing import NamedTuple, Optional, Tuple

import numpy as np

Color = Tuple[float, float, float, float]

GREY: Color = (0.7, 0.7, 0.7, 1.0)      # of what has no material
# from the frame of a camera body (x forward, y to the left, z up) to OpenGL's (x right, y up,
# z backward)
BODY_TO_OPENGL = np.array([[0, -1, 0, 0], [0, 0, 1, 0], [-1, 0, 0, 0], [0, 0, 0, 1]], float)

BOX, CYLINDER, SPHERE, PLANE, MESH = 'box', 'cylinder', 'sphere', 'plane', 'mesh'


class Submesh(NamedTuple):
    """A part of a mesh file; name: of its node, object or group, '' is the whole file.

    is_centered: whether the middle of its bounds is moved to the origin.
    """

    name: str = ''
    is_centered: bool = False


WHOLE = Submesh()


class Shape(NamedTuple):
    """A shape in its own frame, with its center at the origin, in m.

    kind and size: BOX (x, y, z); CYLINDER (radius, length along z); SPHERE (radius,); PLANE
    (x, y), whose upper side is seen; MESH (scale x, y, z), of the file `path` or a part of it.
    """

    kind: str
    size: Tuple[float, ...]
    path: str = ''
    submesh: Submesh = WHOLE


class Material(NamedTuple):
    """A color (red, green, blue, opacity; 0 to 1), multiplied by the image file `texture`.

    texture: '' for none; scale: how large its image is, 1 for all of the texture coordinates;
    pattern: the name of one that `color` is the mean of, '' for none; is_cutout: whether the
    texture is only seen where it is opaque.
    """

    color: Color = GREY
    texture: str = ''
    scale: Tuple[float, float] = (1.0, 1.0)
    pattern: str = ''
    is_cutout: bool = False


class Visual(NamedTuple):
    """A shape of a part of the scene.

    part: the number of the part, whose frame moves; pose (4, 4): of the shape in that frame, a
    homogeneous transform in m; material: None is that of the mesh file, else grey; prefers_file:
    whether `material` is only used for what has none in the mesh file; opacity: by which that of
    a mesh file is multiplied.
    """

    part: int
    shape: Shape
    pose: np.ndarray
    material: Optional[Material] = None
    prefers_file: bool = False
    opacity: float = 1.0


class Light(NamedTuple):
    """How a scene is lit.

    sun (3,): the direction to the sun; background: the color (0 to 1) of the sky at the horizon;
    floor: whether there is a floor at z 0; zenith: the color straight above, None for the same.
    """

    sun: Tuple[float, float, float]
    background: Tuple[float, float, float]
    floor: bool = True
    zenith: Optional[Tuple[float, float, float]] = None


class VisualScene(NamedTuple):
    """All visuals and the light; moving: whether the part of each number can move."""

    visuals: Tuple[Visual, ...]
    moving: Tuple[bool, ...]
    light: Light
