"""Scenes and cameras for tests of drawing."""
import functools
import math

import numpy as np

from img_recog.model import DIRECTIONAL, Light, Material, Surroundings, Visual, VisualScene
from img_recog.rendering.camera import Camera
from img_recog.rendering.opengl import Renderer

RED, GREEN, BLUE = ((1.0, 0.0, 0.0, 1.0), (0.0, 1.0, 0.0, 1.0), (0.0, 0.0, 1.0, 1.0))
ABOVE = (0.0, 0.0, 1.0)
BACKGROUND = (0.5, 0.25, 0.75)
AROUND = Surroundings(ambient=(0.7, 0.7, 0.7), background=BACKGROUND)
CAMERA = Camera(320, 240, math.radians(60))
HERE = np.array([[0.0, 0, 0, 0, 0, 0, 1]])      # one part, at the origin


def at(x, y, z):
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def looking_down(height, x=0.0, y=0.0):
    """Return the pose of a camera above a point: the world's x is upward in its image."""
    pose = at(x, y, height)
    pose[:3, :3] = [[0, 0, 1], [0, 1, 0], [-1, 0, 0]]
    return pose


def visual(shape, pose, color, part=0, texture=''):
    return Visual(part, shape, pose, Material(color, texture))


def sun_from(direction, strength=0.3):
    """Return a sun without highlights; what faces it has its full color, with that of AROUND."""
    return Light(DIRECTIONAL, diffuse=(strength,) * 3, specular=(0.0, 0.0, 0.0),
                 direction=tuple(-axis for axis in direction))


def scene(*visuals, sun=ABOVE, floor=False, moving=(False,), lights=None, around=AROUND):
    lights = [(-1, sun_from(sun))] if lights is None else lights
    return VisualScene(tuple(visuals), moving, tuple(lights), around, floor)


def draw(*visuals, camera=CAMERA, pose=np.eye(4), poses=HERE, **more):
    return loaded(scene(*visuals, **more), poses).draw(camera, pose, poses)


@functools.lru_cache(maxsize=None)
def renderer_of_all():
    """Return the one that the tests of a process use: the first image of each takes long."""
    return Renderer()


def loaded(content, poses):
    """Return the renderer of all, which shows this scene until another one is loaded."""
    renderer = renderer_of_all()
    assert renderer.load(content, poses) == []
    return renderer


def centroid(image):
    """Return the column and row of what is red, to less than a pixel."""
    share = 1 - image[:, :, 2] / round(BACKGROUND[2] * 255)
    share[(image == 0).all(axis=2)] = 0         # black, beside the image
    rows, columns = np.mgrid[:image.shape[0], :image.shape[1]]
    return (share * columns).sum() / share.sum(), (share * rows).sum() / share.sum()


def sky_color(way, background=(255, 255, 255)):
    """Return the colors (..., 3) of the sky in directions, unit vectors (..., 3)."""
    way = np.asarray(way)
    low, cosine = np.minimum(1 - way[..., 2:], 1.23), way @ (0.0, 0.6198, 0.7847)
    square = cosine[..., np.newaxis] ** 2
    light = (1.9801 - 1.98 * cosine[..., np.newaxis]) ** -1.5 * (1 + square) * (
        0.000122, 0.000119, 0.000102)
    for power, color in ((0, (0.235, 0.291, 0.606)), (1, (0.367, 0.428, 0.721)),
                         (4, (0.978, 1.22, 2.4)), (8, (-0.258, -0.462, -2.118)),
                         (16, (-0.069, -0.065, 0.175))):
        light = light + low ** power * color
    for power, color in ((0, (0.103, 0.122, 0.232)), (1, (0.261, 0.333, 0.727)),
                         (4, (0.252, 0.228, -0.206))):
        light = light + square * low ** power * color
    faded = np.clip((low - 1.13) * 10.1, 0, 1)
    faded *= 0.55 + 0.45 * faded
    return 255 * (1 - np.exp(-light)) * (1 - faded) + np.array(background) * faded
