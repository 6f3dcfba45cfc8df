"""Homogeneous transforms and projections as arrays (4, 4); lengths in m, REP 103 axes."""
from typing import Sequence, Union

import numpy as np

from img_recog import rotations
from img_recog.model import BODY_TO_OPENGL
from img_recog.rendering.camera import ImageEdges

Vector = Union[Sequence[float], np.ndarray]


def from_poses(poses: np.ndarray) -> np.ndarray:
    """Return the transforms (n, 4, 4) of poses (n, 7): x, y, z and a quaternion x, y, z, w.

    >>> from_poses(np.array([[1, 2, 3, 0, 0, 1, 1]])).tolist()     # a quarter turn to the left
    [[[0.0, -1.0, 0.0, 1.0], [1.0, 0.0, 0.0, 2.0], [0.0, 0.0, 1.0, 3.0], [0.0, 0.0, 0.0, 1.0]]]
    """
    matrices = np.zeros((len(poses), 4, 4))
    matrices[:, :3, :3] = np.array(rotations.elements(
        *np.asarray(poses, float)[:, 3:].T)).T.reshape(-1, 3, 3)
    matrices[:, :3, 3] = np.asarray(poses)[:, :3]
    matrices[:, 3, 3] = 1
    return matrices


def of_parts(models: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return the transforms (k, 4, 4) of parts (k,) by their numbers, of which -1 is the world.

    models (n, 4, 4): the transforms of all parts to the world.
    """
    return np.concatenate([models, np.eye(4)[np.newaxis]])[parts]


def inverse(pose: np.ndarray) -> np.ndarray:
    """Return the inverse of a rigid transform.

    np.linalg.inv wakes a thread of OpenBLAS for each core, and each waits for more work in a loop:
    that took a quarter of the processor time of an image.
    """
    matrix = np.eye(4)
    matrix[:3, :3] = pose[:3, :3].T
    matrix[:3, 3] = -(pose[:3, :3].T @ pose[:3, 3])
    return matrix


def view(camera_pose: np.ndarray) -> np.ndarray:
    """Return the transform from the world to OpenGL's camera frame.

    camera_pose (4, 4): of the camera body, which looks along its x axis, in the world.

    >>> (view(np.eye(4)) @ (5, 0, 1, 1)).tolist()       # 5 m ahead and 1 m up
    [0.0, 1.0, -5.0, 1.0]
    """
    return BODY_TO_OPENGL @ inverse(camera_pose)


def perspective(edges: ImageEdges, near: float, far: float) -> np.ndarray:
    """Return the projection of a pinhole camera.

    >>> seen = perspective(ImageEdges(-2.0, 4.0, -1.0, 1.0), 1.0, 9.0) @ (16, 0, -4, 1)
    >>> (seen / seen[3]).tolist()[0]        # at the right edge, 4 m ahead
    1.0
    """
    left, right, bottom, top = edges
    return np.array([[2 / (right - left), 0, (right + left) / (right - left), 0],
                     [0, 2 / (top - bottom), (top + bottom) / (top - bottom), 0],
                     [0, 0, -(far + near) / (far - near), -2 * far * near / (far - near)],
                     [0, 0, -1, 0]])


def to_bytes(matrix: np.ndarray) -> bytes:
    """Return a matrix as OpenGL stores it: 32 bits a number, by columns."""
    return matrix.T.astype('f4').tobytes()
