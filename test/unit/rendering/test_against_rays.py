"""Images and depths are those of a simple reference, which follows a ray from each pixel."""
import math
from typing import NamedTuple

import cv2
import numpy as np
import pytest

from img_recog import rotations
from img_recog.model import BOX, Shape
from img_recog.rendering import matrices
from img_recog.rendering.camera import Camera
from img_recog_helpers.drawn import BACKGROUND, loaded, scene, visual

CAMERA = Camera(120, 90, math.radians(70), 0.1, 60.0)
FLOOR_AMBIENT, FLOOR_DIFFUSE = 0.3, 0.7
MIDDLE = np.array([7.0, -5.0, 0.0])     # of the scene: not the origin


class Solid(NamedTuple):
    pose: np.ndarray
    size: np.ndarray
    color: np.ndarray


def enters(solid, starts, directions):
    """Return for each ray (n, 3) where it enters a box, inf for nowhere, and the normal there."""
    rotation, middle = solid.pose[:3, :3], solid.pose[:3, 3]
    start, direction = (starts - middle) @ rotation, directions @ rotation
    planes = np.stack([(side * solid.size / 2 - start) / direction for side in (-1, 1)])
    entries = planes.min(axis=0)
    axis = entries.argmax(axis=1)
    distance = entries.max(axis=1)
    is_hit = (distance <= planes.max(axis=0).min(axis=1)) & (distance > 1e-6)
    signs = -np.sign(np.take_along_axis(direction, axis[:, None], axis=1))
    return np.where(is_hit, distance, np.inf), signs * rotation.T[axis]


def reference(solids, pose, sun, floor, ceiling):
    """Return an image, and its depths."""
    left, right, bottom, top = CAMERA.edges
    columns, rows = np.meshgrid((np.arange(CAMERA.width) + 0.5) / CAMERA.width,
                                (np.arange(CAMERA.height) + 0.5) / CAMERA.height)
    directions = np.stack([np.ones_like(rows), -(left + columns * (right - left)),
                           top - rows * (top - bottom)], axis=-1).reshape(-1, 3) @ pose[:3, :3].T
    starts = np.broadcast_to(pose[:3, 3], directions.shape)
    depths = np.where(floor & (directions[:, 2] < 0), -pose[2, 3] / directions[:, 2], np.inf)
    depths[depths > CAMERA.far] = np.inf
    normals = np.broadcast_to((0.0, 0.0, 1.0), directions.shape).copy()
    colors = np.where(np.isfinite(depths)[:, None], FLOOR_DIFFUSE, BACKGROUND)
    ambient = np.where(np.isfinite(depths)[:, None], FLOOR_AMBIENT, BACKGROUND)
    for solid in solids:
        found, normal = enters(solid, starts, directions)
        with np.errstate(invalid='ignore'):
            is_nearer = (found < depths) & ((starts + found[:, None] * directions)[:, 2] < ceiling)
        depths = np.where(is_nearer, found, depths)
        normals[is_nearer], colors[is_nearer] = normal[is_nearer], solid.color
        ambient[is_nearer] = solid.color
    is_seen = np.isfinite(depths)
    cosines = np.maximum(normals[is_seen] @ sun, 0)[:, None]
    colors[is_seen] = 0.7 * ambient[is_seen] + 0.3 * cosines * colors[is_seen]
    shape = CAMERA.height, CAMERA.width
    return 255 * colors.reshape(*shape, 3), depths.reshape(shape)


def pose_of(x, y, z, *rpy):
    return matrices.from_poses(np.array([[x, y, z, *rotations.quaternion_of(
        rotations.from_rpy(rpy))]]))[0]


@pytest.mark.parametrize('seed', range(4))
def test_boxes_and_the_floor(seed):
    random = np.random.RandomState(seed)
    count, floor = 8, seed != 1
    moving = np.arange(count) < 3
    sizes, colors = random.uniform(0.3, 1.5, (count, 3)), random.randint(50, 256, (count, 3)) / 255
    sun = np.array([*random.uniform(-0.8, 0.8, 2), 0.05 if seed == 3 else 0.6])
    sun /= np.linalg.norm(sun)
    poses = np.array([[*random.uniform(-3, 3, 2), random.uniform(0.8, 2.5),
                       *random.normal(size=4)] for _ in range(count)])
    poses[:, 3:] /= np.linalg.norm(poses[:, 3:], axis=1, keepdims=True)
    poses[:, :3] += MIDDLE
    poses[2, 0] += 70 * (seed == 2)     # not seen, and it does not matter
    offset = pose_of(0.2, -0.1, 0.3, 0.1, 0.2, 0.3)     # of each box in its part
    content = scene(*(visual(Shape(BOX, tuple(size)), offset, (*color, 1.0), part)
                      for part, (size, color) in enumerate(zip(sizes, colors))),
                    sun=tuple(3 * sun), floor=floor, moving=tuple(moving.tolist()))
    renderer = loaded(content, poses)
    for number in range(3):
        solids = [Solid(pose @ offset, size, color) for pose, size, color in zip(
            matrices.from_poses(poses), sizes, colors)]
        for angle in random.uniform(-math.pi, math.pi, 2):
            pose = pose_of(*(MIDDLE[:2] - 6 * np.array([math.cos(angle), math.sin(angle)])),
                           random.uniform(2.0, 4.0), 0.05, random.uniform(0.2, 0.5), angle)
            ceiling = (math.inf, 1.8)[number % 2]
            expected, distances = reference(solids, pose, sun, floor, ceiling)
            image = renderer.draw(CAMERA, pose, poses, ceiling)
            # not at edges, where the one pixel or the other is right
            kernel = np.ones((5, 5))
            is_inside = (cv2.dilate(expected, kernel)
                         - cv2.erode(expected, kernel)).max(axis=2) < 8
            wrong = np.abs(image - expected).max(axis=2)[is_inside] > 3
            assert is_inside.mean() > 0.5 and wrong.mean() < 0.006
            if ceiling == math.inf:
                depth = renderer.depth(CAMERA, pose, poses)
                is_equal = np.isclose(depth, distances, rtol=0.002)[is_inside]
                assert is_equal.mean() > 0.998
        poses[moving, :2] += random.uniform(-1.5, 1.5, (moving.sum(), 2))
