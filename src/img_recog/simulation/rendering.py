"""Images of a physics client without a display, lit like PyBullet's OpenGL window.

PyBullet's TinyRenderer paints the bodies; the floor (the plane z 0, which must not be a visible
body) and the shadows are added here, from depth images seen from the camera and from the sun.
"""
import math
from typing import List, NamedTuple, Sequence, Tuple

import numpy as np
import pybullet

from img_recog.simulation.geometry import Numbers

# the direction to the sun: the opposite of <direction> of Gazebo's default sun
SUN = (0.5, -0.1, 0.9)
# For pybullet.configureDebugVisualizer. Far away, so that all light has the same direction;
# bodies need specularColor (0, 0, 0), or a tall one shows a reflection of the light.
WINDOW_LIGHT = {'lightPosition': tuple(100 * axis for axis in SUN), 'shadowMapWorldSize': 14,
                'shadowMapResolution': 4096}
GREY = np.uint8(178)            # floor and background (0.7) of the window: there is no horizon
FLOOR_SHADOW = np.uint8(152)    # floor of the window in shadow
# The window's shader (useShadowMapInstancingPS.glsl, with an ambient light of 0.5) gives
# 0.75 + 0.25 c of its color to a face with cosine c between normal and sun; TinyRenderer can do
# the same. Faces in shadow or turned away get 0.675 + 0.175 c there, and 0.75 by TinyRenderer.
_SHADING = {'lightDirection': SUN, 'lightColor': (1, 1, 1), 'lightAmbientCoeff': 0.75,
            'lightDiffuseCoeff': 0.25, 'lightSpecularCoeff': 0.0}
_AWAY_FACTOR, _AWAY_SLOPE = 0.675 / 0.75, 0.175 / 0.75
_SHADOW_FACTOR = 0.87           # for all c from 0 to 1 within 0.03
FIELD_OF_VIEW = 46.8            # degrees, vertical: 60 horizontally at 4:3, like Gazebo's camera
_NEAR, _FAR = 0.05, 60.0        # m, of the camera
_SUN_NEAR, _SUN_FAR = 50.0, 150.0   # m, of the sun, which is 100 m from the origin
_SUN_VIEW = np.reshape(pybullet.computeViewMatrix(
    WINDOW_LIGHT['lightPosition'], (0, 0, 0), (0, 0, 1)), (4, 4)).T
_BAND_ROWS = 60                 # at a time: numpy is three times as fast within the cache


class Camera(NamedTuple):
    """A camera like that of pybullet.computeViewMatrixFromYawPitchRoll.

    target: m, in the world; distance: m; yaw, pitch: degrees.
    """

    target: Tuple[float, float, float]
    distance: float
    yaw: float
    pitch: float


class _SunMap(NamedTuple):
    """A square seen from the sun: lower left `corner` in m, `texel` side in m and `distances`.

    distances (size, size): m from the sun to the nearest body, the upper row first.
    """

    corner: np.ndarray
    texel: float
    distances: np.ndarray


def render(physics_client_id: int, camera: Camera, width: int, height: int) -> np.ndarray:
    """Return an RGB image, uint8 of shape (height, width, 3)."""
    view = np.reshape(pybullet.computeViewMatrixFromYawPitchRoll(
        camera.target, camera.distance, camera.yaw, camera.pitch, 0, 2), (4, 4)).T
    projection = pybullet.computeProjectionMatrixFOV(FIELD_OF_VIEW, width / height, _NEAR, _FAR)
    pixels, depth = _draw(physics_client_id, view, projection, width, height)
    sun_maps = _sun_maps(physics_client_id, camera, view)
    to_world = np.linalg.inv(view)
    # TinyRenderer's pixel (0, 0) is the lower left corner itself, not the middle of a square
    slope = math.tan(math.radians(FIELD_OF_VIEW / 2))
    x = np.linspace(-1, 1, width, False) * slope * width / height
    y = np.linspace(-1, 1, height, False)[::-1] * slope
    for rows in np.array_split(np.arange(height), -(-height // _BAND_ROWS)):
        band = slice(rows[0], rows[-1] + 1)
        _shade(pixels[band], _distance(depth[band], _NEAR, _FAR), to_world, (x, y[band]), sun_maps)
    return np.ascontiguousarray(pixels[:, :, :3])


def _shade(pixels: np.ndarray, distance: np.ndarray, to_world: np.ndarray,
           rays: Tuple[np.ndarray, np.ndarray], sun_maps: List[_SunMap]) -> None:
    """Paint floor, background and shadows into `pixels` (rows, columns, 4).

    distance (rows, columns): m along the optical axis; to_world (4, 4): from the camera's frame;
    rays: x of the columns and y of the rows, 1 m along the optical axis.
    """
    to_floor = _floor_distances(to_world, rays)
    floor = to_floor < distance
    distance = np.minimum(distance, to_floor)
    points = [distance * _along(axis, rays) + np.float32(axis[3])
              for axis in (_SUN_VIEW @ to_world)[:3]]
    cosines = _cosines(points)
    # a body must not shadow itself where its depth changes within a texel
    sines = np.sqrt(np.maximum(1 - cosines * cosines, 0))
    slack = np.float32(0.5) + sines / np.maximum(np.abs(cosines), np.float32(0.1))
    slack[floor] = 0
    dark = _in_shadow(points, slack, sun_maps)
    # the four bytes of a grey pixel at once
    greys = np.where(dark, FLOOR_SHADOW, GREY) * np.uint32(0x01010101)
    np.copyto(pixels.view(np.uint32)[:, :, 0], greys, where=floor)
    dark = (dark | (cosines < 0)) & ~floor
    cosines = cosines[dark]
    factors = np.where(cosines < 0, _AWAY_FACTOR + _AWAY_SLOPE * cosines, _SHADOW_FACTOR)
    pixels[dark] = pixels[dark] * factors[:, None].astype(np.float32)


def _floor_distances(to_world: np.ndarray, rays: Tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return how far along the optical axis the floor is, in m, for arguments as in `_shade`.

    Where there is no floor it is a little less than _FAR: the background has the floor's color.
    """
    eye_height, farthest = to_world[2, 3], 0.99 * _FAR
    if eye_height <= 0:
        return np.full((len(rays[1]), len(rays[0])), farthest, np.float32)
    falling = np.maximum(-_along(to_world[2], rays), np.float32(eye_height / farthest))
    return np.float32(eye_height) / falling


def _along(axis: np.ndarray, rays: Tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return how far `rays` (as in `_shade`) lead along an axis given in the camera's frame."""
    x, y = rays
    return (axis[0] * x - axis[2]).astype(np.float32) + (axis[1] * y).astype(np.float32)[:, None]


def _cosines(points: List[np.ndarray]) -> np.ndarray:
    """Return the cosine between sun and normal of each point's face.

    points: as in `_in_shadow`. Where two faces meet it is never negative.
    """
    right = [np.diff(axis, axis=1) for axis in points]
    down = [np.diff(axis, axis=0) for axis in points]
    ahead = [axis[1:-1, 1:] for axis in right], [axis[1:, 1:-1] for axis in down]
    behind = [axis[1:-1, :-1] for axis in right], [axis[:-1, 1:-1] for axis in down]
    across, up, sun = (_normal(*ahead, axis) for axis in range(3))
    cosine = sun / np.sqrt(across * across + up * up + sun * sun + np.float32(1e-20))
    # next to an edge only one of the two normals is of the face itself
    away = (sun < 0) & (_normal(*behind, 2) < 0)
    return np.pad(np.where(away, cosine, np.abs(cosine)), 1, 'edge')


def _normal(right: List[np.ndarray], down: List[np.ndarray], axis: int) -> np.ndarray:
    """Return a component of the normal that the steps to the right and down in an image span."""
    return down[axis - 2] * right[axis - 1] - down[axis - 1] * right[axis - 2]


def _in_shadow(points: List[np.ndarray], slack: np.ndarray,
               sun_maps: List[_SunMap]) -> np.ndarray:
    """Return which points are in shadow; the last map that holds a point decides.

    points: across, up and towards the sun in its view, each an image in m; slack: by how many
    texel sides a point may be behind the nearest body as seen from the sun.
    """
    across, up, depth = points
    dark = np.zeros(slack.shape, bool)
    for corner, texel, distances in sun_maps:
        size = len(distances)
        left, low = corner.astype(np.float32)
        column = ((across - left) / np.float32(texel) + np.float32(0.5)).astype(np.int32)
        row = size - 1 - ((up - low) / np.float32(texel) + np.float32(0.5)).astype(np.int32)
        inside = (column >= 0) & (column < size) & (row >= 0) & (row < size)
        nearest = distances.take(row * size + column, mode='clip')
        hidden = -depth > nearest + slack * np.float32(texel)
        np.copyto(dark, hidden, where=inside)
    return dark


def _sun_maps(physics_client_id: int, camera: Camera, view: np.ndarray) -> List[_SunMap]:
    """Return depth images from the sun: a wide region, and a fine one about a near target."""
    # a level camera shows more of what is behind its target
    ahead = camera.target - 1.5 * np.array((view[2, 0], view[2, 1], 0))
    maps = [_sun_map(physics_client_id, ahead, 5.2, 448)]
    if camera.distance < 4.0:
        half = max(0.5, 0.6 * camera.distance)
        maps.append(_sun_map(physics_client_id, camera.target, half, 256))
    return maps


def _sun_map(physics_client_id: int, center: Numbers, half: float,
             size: int) -> _SunMap:
    """Return the square with sides 2 * half (m) about `center` as seen from the sun."""
    texel = 2 * half / size
    # rounded to texels, or the edges of shadows flicker when the target moves
    middle = np.round((_SUN_VIEW @ (*center, 1.0))[:2] / texel) * texel
    projection = list(pybullet.computeProjectionMatrixFOV(90, 1, _SUN_NEAR, _SUN_FAR))
    projection[0] = projection[5] = 1 / half
    projection[12:14] = -middle / half
    # w is 1 for parallel light; z keeps its form, by which TinyRenderer encodes the depth
    projection[11], projection[15] = 0.0, 1.0
    _, depth = _draw(physics_client_id, _SUN_VIEW, projection, size, size)
    return _SunMap(middle - half, texel, _distance(depth, _SUN_NEAR, _SUN_FAR))


def _draw(physics_client_id: int, view: np.ndarray, projection: Sequence[float], width: int,
          height: int) -> Tuple[np.ndarray, np.ndarray]:
    """Return the RGBA pixels and the depth buffer of the bodies."""
    drawn = pybullet.getCameraImage(
        width, height, view.T.ravel().tolist(), projection, shadow=0,
        flags=pybullet.ER_NO_SEGMENTATION_MASK, renderer=pybullet.ER_TINY_RENDERER,
        physicsClientId=physics_client_id, **_SHADING)
    return (np.reshape(drawn[2], (height, width, 4)).astype(np.uint8),
            np.reshape(drawn[3], (height, width)).astype(np.float32))


def _distance(depth: np.ndarray, near: float, far: float) -> np.ndarray:
    """Return the distances in m along the optical axis that a depth buffer encodes."""
    return np.float32(far * near) / (np.float32(far) - np.float32(far - near) * depth)
