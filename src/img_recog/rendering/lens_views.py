"""Draws what a camera sees through a lens, with a renderer of pinhole cameras.

A few of the six faces of a cube around the camera are drawn, each no larger and no sharper than
the image needs it, and the pixels of the image are looked up in them.
"""
import functools
import math
from typing import Any, List, NamedTuple, Tuple

import cv2
import numpy as np

from img_recog.rendering.camera import Camera, View, ImageEdges
from img_recog.rendering.rays import directions

_MAX_SLOPE = 2.0            # what is nearer to the axis is drawn in one piece
_MAX_SIDE_PX = 4096
_MARGIN_PX = 2              # around what is looked up, between pixels
# the shares of the distances between pixels, by which a face is not sharp enough
_SHARPNESS_QUANTILE = 0.1
_NOWHERE = -10.0            # a place beside all pixels
_OPTICAL_TO_BODY = np.array([[0, 0, 1], [-1, 0, 0], [0, -1, 0]])
# the x, y and z axes of the faces in the optical frame of the camera; the first is ahead
_FACES = np.array([
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
    [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
    [[1, 0, 0], [0, 0, 1], [0, -1, 0]], [[-1, 0, 0], [0, 1, 0], [0, 0, -1]]])


class Face(NamedTuple):
    """A picture that is drawn; turn (4, 4): from the body of its camera to that of the lens."""

    view: View
    turn: np.ndarray


class Lookup(NamedTuple):
    """How an image is made of faces that are stacked, one below the other.

    maps: the places of the pixels, for cv2.remap; depth_factors (height, width): the distance
    along the optical axis for each meter along that of the face.
    """

    faces: List[Face]
    maps: Tuple[np.ndarray, np.ndarray]
    depth_factors: np.ndarray


def draw(renderer: Any, camera: Camera, pose: np.ndarray, poses: np.ndarray,
         ceiling: float = math.inf) -> np.ndarray:
    """Return an image like opengl.Renderer.draw, of a camera that may have a lens."""
    if camera.lens is None:
        return renderer.draw(camera, pose, poses, ceiling)
    lookup = lookup_of(camera)
    stacked = _stacked(lookup, 3, np.uint8, lambda face: renderer.draw(
        face.view, pose @ face.turn, poses, ceiling))
    return cv2.remap(stacked, *lookup.maps, cv2.INTER_LINEAR)


def depth(renderer: Any, camera: Camera, pose: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return depths like opengl.Renderer.depth, of a camera that may have a lens."""
    if camera.lens is None:
        return renderer.depth(camera, pose, poses)
    lookup = lookup_of(camera)
    stacked = _stacked(lookup, 1, np.float32, lambda face: renderer.depth(
        face.view, pose @ face.turn, poses)[..., np.newaxis])
    depths = cv2.remap(stacked, *lookup.maps, cv2.INTER_NEAREST, borderValue=math.inf)
    return np.where(np.isfinite(depths), depths * lookup.depth_factors, np.float32(np.inf))


def _stacked(lookup: Lookup, channels: int, dtype: type, draw_face: Any) -> np.ndarray:
    views = [face.view for face in lookup.faces]
    shape = sum(view.height for view in views), max(view.width for view in views), channels
    stacked: np.ndarray = np.empty(shape, dtype)
    row = 0
    for face in lookup.faces:
        stacked[row:row + face.view.height, :face.view.width] = draw_face(face)
        row += face.view.height
    return stacked


@functools.lru_cache(maxsize=32)
def lookup_of(camera: Camera) -> Lookup:
    """Return how the image of a camera with a lens is made."""
    seen = directions(camera)
    is_seen = ~np.isnan(seen[..., 2])
    sine = np.hypot(seen[..., 0], seen[..., 1])
    if (sine <= _MAX_SLOPE * seen[..., 2])[is_seen].all():
        face_of = np.where(is_seen, 0, -1)
    else:
        # of all axes, that of the face of a direction is the nearest
        face_of = np.where(is_seen, np.argmax(seen @ _FACES[:, 2].T, axis=-1), -1)
    faces, row = [], 0
    columns, rows = (np.full(face_of.shape, _NOWHERE, np.float32) for _ in range(2))
    depth_factors = np.ones(face_of.shape, np.float32)
    for number in np.unique(face_of[is_seen]).tolist() or [0]:
        here = face_of == number
        x, y, z = np.moveaxis(seen @ _FACES[number].T, -1, 0)
        with np.errstate(invalid='ignore', divide='ignore'):
            x, y = x / z, y / z
            depth_factors[here] = (seen[..., 2] / z)[here]
        view = _view(camera, x, y, here)
        pixels = view.width / (view.edges.right - view.edges.left)
        columns[here] = ((x - view.edges.left) * pixels - 0.5)[here]
        rows[here] = ((y + view.edges.top) * pixels - 0.5 + row)[here]
        faces.append(Face(view, _turn(number)))
        row += view.height
    return Lookup(faces, cv2.convertMaps(columns, rows, cv2.CV_16SC2), depth_factors)


def _view(camera: Camera, x: np.ndarray, y: np.ndarray, here: np.ndarray) -> View:
    """Return the smallest view that shows pixels `here`, where x and y (downward) are slopes."""
    if not here.any():
        return View(1, 1, ImageEdges(-1, 1, -1, 1), camera.near, camera.far)
    steps = np.concatenate([np.hypot(np.diff(x, axis=axis), np.diff(y, axis=axis))[both]
                            for axis, both in ((0, here[1:] & here[:-1]),
                                               (1, here[:, 1:] & here[:, :-1]))])
    low, high = (np.array([edge(x[here]), edge(y[here])]) for edge in (np.min, np.max))
    pixels = _MAX_SIDE_PX / max(1.0, (high - low).max())
    if len(steps):
        pixels = min(pixels, 1 / float(np.quantile(steps, _SHARPNESS_QUANTILE)))
    pixels = min(pixels, getattr(camera.lens, 'texture_size', math.inf) / 2)
    width, height = (np.ceil((high - low) * pixels).astype(int) + 2 * _MARGIN_PX).tolist()
    left, top = (low - _MARGIN_PX / pixels).tolist()
    edges = ImageEdges(left, left + width / pixels, -top - height / pixels, -top)
    return View(width, height, edges, camera.near, camera.far)


def _turn(number: int) -> np.ndarray:
    turn = np.eye(4)
    turn[:3, :3] = _OPTICAL_TO_BODY @ _FACES[number].T @ _OPTICAL_TO_BODY.T
    return turn
