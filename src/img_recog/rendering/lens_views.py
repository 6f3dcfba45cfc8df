"""Draws the images of cameras with lenses, by a renderer of pinhole cameras.

A few of the six faces of a cube around the camera are drawn, each no larger and no sharper than
the image needs it, and the pixels of the image are looked up in them.
"""
import functools
import math
from typing import Any, List, NamedTuple, Optional, Tuple

import cv2
import numpy as np

from img_recog.formats.lenses import ID, TAN, Distortion, Lens
from img_recog.rendering.camera import Camera, ImageEdges, Intrinsics, View

PLUMB_BOB, EQUIDISTANT = 'plumb_bob', 'equidistant'     # sensor_msgs/distortion_models.h
_UNDISTORTED = (0.0,) * 5   # for plumb_bob
_MAX_ERROR_PX = 0.5         # of a model
_SAMPLES = 200
_POWERS = 3, 5, 7, 9        # of the angle, that k1 to k4 belong to
_CRITERIA = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, 100, 1e-9)
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


class CameraModel(NamedTuple):
    """The distortion model of sensor_msgs/CameraInfo, its D, and what K is made of."""

    model: str
    coefficients: Tuple[float, ...]
    intrinsics: Intrinsics


@functools.lru_cache(maxsize=32)
def directions(camera: Camera) -> np.ndarray:
    """Return the unit vectors (height, width, 3) along which pixels look, NaN for black ones.

    In the optical frame: x to the right, y downward, z forward (REP 103). It must not be changed.
    """
    width, height = camera.width, camera.height
    x, y = np.meshgrid(2 * np.arange(width) + 1 - width, 2 * np.arange(height) + 1 - height)
    x, y = x / width, y / width         # in halves of the width
    lens = camera.lens
    if isinstance(lens, Lens):
        radius = np.hypot(x, y)
        angle = lens.angle(radius)
        share = np.sin(angle) / np.maximum(radius, 1e-12)
        found = np.stack([share * x, share * y, np.cos(angle)], axis=-1)
    else:
        slope = camera.edges.right
        found = np.stack([slope * x, slope * y, np.ones_like(x)], axis=-1)
        if lens is not None:
            found = _undistorted(found, lens, camera.intrinsics.fx)
        found /= np.linalg.norm(found, axis=-1, keepdims=True)
    found.flags.writeable = False
    return found


@functools.lru_cache(maxsize=32)
def slopes(camera: Camera) -> Tuple[np.ndarray, np.ndarray]:
    """Return x and y of these directions at z 1, float32 (height, width). Do not change them."""
    found = directions(camera)
    x, y = ((found[..., axis] / found[..., 2]).astype(np.float32) for axis in (0, 1))
    return x, y


def _undistorted(found: np.ndarray, lens: Distortion, focal_px: float) -> np.ndarray:
    """Return the directions (height, width, 3), with z 1, that a distortion moves to `found`."""
    given = found[..., :2].reshape(-1, 1, 2)
    coefficients = np.array(lens)
    undistorted = cv2.undistortPointsIter(given, np.eye(3), coefficients, np.eye(3), np.eye(3),
                                          _CRITERIA)
    points = cv2.convertPointsToHomogeneous(undistorted)
    again, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), coefficients)
    # no direction is seen at a place that the polynomial does not reach
    wrong = np.abs(again - given).max(axis=2).ravel() * focal_px > _MAX_ERROR_PX
    points[wrong | ~np.isfinite(again).all(axis=2).ravel()] = np.nan
    return points.reshape(found.shape)


def model_of(camera: Camera) -> Optional[CameraModel]:
    """Return the model of a camera, None if no model can say what its lens does.

    A Lens that is not a pinhole is said by the model equidistant, also known as fisheye: a
    direction at an angle t is seen t (1 + k1 t^2 + k2 t^4 + k3 t^6 + k4 t^8) focal lengths from
    the principal point. The coefficients are 0 for the function id, and else the nearest for the
    angles in the image.
    """
    lens = camera.lens
    if not isinstance(lens, Lens):
        return CameraModel(PLUMB_BOB, tuple(lens or _UNDISTORTED), camera.intrinsics)
    focal_px = camera.width / 2 * lens.scale / lens.divisor
    intrinsics = camera.with_focal_length(focal_px)
    if lens.offset:
        return None         # its middle is not a point
    if lens.function == TAN and lens.divisor == 1:
        return CameraModel(PLUMB_BOB, _UNDISTORTED, intrinsics)
    if lens.function == ID:
        return CameraModel(EQUIDISTANT, (0.0,) * 4, intrinsics)
    z = directions(camera)[..., 2]
    if np.isnan(z).all():
        return None
    share = np.arange(1, _SAMPLES + 1) / _SAMPLES
    angle = share * np.arccos(np.nanmin(z))
    rest = camera.width / 2 * lens.radius(angle) - focal_px * angle
    columns = np.stack([share ** power for power in _POWERS], axis=1)
    factors = np.linalg.lstsq(columns, rest, rcond=None)[0]
    if np.abs(columns @ factors - rest).max() > _MAX_ERROR_PX:
        return None
    coefficients = factors / focal_px / angle[-1] ** np.array(_POWERS)
    return CameraModel(EQUIDISTANT, tuple(coefficients.tolist()), intrinsics)


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
