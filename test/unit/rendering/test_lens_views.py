"""Images through lenses: where things are."""
import math

import numpy as np
import pytest

from img_recog import rotations
from img_recog.formats import lenses
from img_recog.formats.lenses import Distortion, Lens
from img_recog.model import BOX, SPHERE, Shape, Surroundings
from img_recog.rendering import lens_views, matrices
from img_recog.rendering.camera import Camera, View, ImageEdges
from img_recog.rendering.lens_views import directions
from img_recog_helpers.drawn import (HERE, RED, at, centroid, loaded, scene, sky_color,
                                     visual)

SIZE = 320, 240
TYPES = {kind: lenses.scaled_to(lenses.of_type(kind), 2.4) for kind in lenses.TYPES[:-1]}
LENSES = {**TYPES, 'round': lenses.scaled_to(Lens(1.0), 1.9 * math.pi), 'custom':
          lenses.scaled_to(Lens(1.05, 4.0, 0.0, 'tan', texture_size=512), 3.183)}


def seen(lens, *visuals, pose=np.eye(4), fov=1.0):
    renderer = loaded(scene(*visuals), HERE)
    camera = Camera(*SIZE, fov, 0.05, 50.0, lens)
    return (lens_views.draw(renderer, camera, pose, HERE),
            lens_views.depth(renderer, camera, pose, HERE))


@pytest.mark.parametrize('name, degrees, around', [
    *((kind, degrees, around) for kind in TYPES for degrees, around in ((0, 0), (30, 20),
                                                                        (60, -170))),
    ('custom', 88, 5), ('custom', 65, 95), ('custom', 105, 37), ('custom', 44, 180),
    ('round', 120, 10), ('round', 165, 0)])
def test_a_ball_is_drawn_at_the_radius_of_its_angle(name, degrees, around):
    angle, side = math.radians(degrees), math.radians(around)
    right, down = math.sin(angle) * math.cos(side), math.sin(angle) * math.sin(side)
    ball = visual(Shape(SPHERE, (0.1,)), at(4 * math.cos(angle), -4 * right, -4 * down), RED)
    image, depth = seen(LENSES[name], ball)
    radius = SIZE[0] / 2 * float(LENSES[name].radius(angle))
    place = 159.5 + radius * math.cos(side), 119.5 + radius * math.sin(side)
    assert centroid(image) == pytest.approx(place, abs=0.5)
    along = depth[round(place[1]), round(place[0])]
    assert along == pytest.approx(4 * math.cos(angle), abs=0.11)


def test_the_faces_of_the_cube_join():
    # walls all around; a seam would show the background
    walls = [visual(Shape(BOX, tuple(7.0 - 6.9 * np.abs(middle))), at(*np.multiply(3.5, middle)),
                    (1.0, 1.0, 1.0, 1.0)) for middle in (*np.eye(3), *-np.eye(3))]
    image, depth = seen(LENSES['round'], *walls)
    shown = ~(image == 0).all(axis=2)
    assert shown.mean() > 0.7 and np.ptp(image[shown], axis=1).max() <= 1
    assert np.isfinite(depth[shown]).all() and np.isinf(depth[~shown]).all()


def test_what_is_beyond_the_cutoff_angle_is_black():
    lens = LENSES['round']._replace(cutoff_angle=1.0)
    image, depth = seen(lens)
    radius = SIZE[0] / 2 * float(lens.radius(1.0))
    rows, columns = np.mgrid[:SIZE[1], :SIZE[0]]
    distance = np.hypot(columns - 159.5, rows - 119.5)
    assert (image[distance > radius + 1] == 0).all()
    assert (image[distance < radius - 1] == [128, 64, 191]).all()
    assert np.isinf(depth).all()


def test_only_the_faces_that_are_seen_are_drawn():
    def faces(lens):
        return [face.view for face in lens_views.lookup_of(Camera(*SIZE, 1.0, lens=lens)).faces]
    assert len(faces(TYPES['equidistant']._replace(cutoff_angle=1.0))) == 1
    assert len(faces(LENSES['custom'])) == 5 and len(faces(LENSES['round'])) == 6
    pixels = sum(view.width * view.height for view in faces(LENSES['custom']))
    assert pixels < 640 * 480
    # not sharper than <env_texture_size>
    coarse = faces(LENSES['custom']._replace(texture_size=64))
    assert max(view.width for view in coarse) == 64 + 4
    # up to a slope of 2
    assert len(faces(TYPES['equidistant']._replace(cutoff_angle=math.atan(1.95)))) == 1
    assert len(faces(TYPES['equidistant']._replace(cutoff_angle=math.atan(2.1)))) == 5
    assert len(faces(Lens(1.0, cutoff_angle=1e-6))) == 1


def test_the_size_of_faces():
    def faces(*size_and_fov, lens=Distortion(0.0, 0.0, 0.0, 0.0, 0.0)):
        camera = Camera(*size_and_fov, 0.2, 30.0, lens)
        assert lens_views.lookup_of(camera) is lens_views.lookup_of(camera)
        return [face.view for face in lens_views.lookup_of(camera).faces]
    side = 2 / 128
    assert faces(1, 1, 1.0, lens=Lens(1.0)) == [
        View(4, 4, ImageEdges(-side, side, -side, side), 0.2, 30.0)]
    assert faces(4, 2, 1.0, lens=Lens(1.0, cutoff_angle=1e-6)) == [
        View(1, 1, ImageEdges(-1, 1, -1, 1), 0.2, 30.0)]
    # as sharp as the image, but for very large ones
    view, = faces(320, 240, 1.0)
    assert (view.width, view.height) == (pytest.approx(323, abs=1), pytest.approx(243, abs=1))
    assert faces(320, 1, 1.0)[0].width == pytest.approx(323, abs=1)
    assert faces(1, 240, 0.004)[0].height == pytest.approx(243, abs=1)
    view, = faces(9000, 2, 1.2)
    assert view.width == 4096 + 4
    view, = faces(9000, 2, 0.5)
    assert view.width == pytest.approx(2 * math.tan(0.25) * 4096 + 4, abs=1)


class Plain:
    """A renderer that draws one color and depth, and keeps what it is asked."""

    def __init__(self):
        self.asked = []

    def draw(self, view, *where):
        self.asked.append((view, where))
        return np.full((view.height, view.width, 3), (10, 20, 30), np.uint8)

    def depth(self, view, *where):
        self.asked.append((view, where))
        return np.full((view.height, view.width), 2.0, np.float32)


def test_what_the_renderer_is_asked():
    renderer, pose = Plain(), at(1, 2, 3)
    camera = Camera(8, 6, 1.0, 0.2, 30.0)
    assert lens_views.draw(renderer, camera, pose, HERE, 4.0).shape == (6, 8, 3)
    assert lens_views.depth(renderer, camera, pose, HERE).shape == (6, 8)
    assert renderer.asked == [(camera, (pose, HERE, 4.0)), (camera, (pose, HERE))]
    camera, renderer.asked = camera._replace(lens=Lens(1.0, cutoff_angle=0.9)), []
    image = lens_views.draw(renderer, camera, pose, HERE, 4.0)
    depth = lens_views.depth(renderer, camera, pose, HERE)
    assert [where[1:] for _, where in renderer.asked] == [(HERE, 4.0), (HERE,)]
    assert all(np.allclose(where[0], pose) for _, where in renderer.asked)
    shown = np.isfinite(depth)
    assert 0 < np.count_nonzero(shown) < 48
    assert (image[shown] == (10, 20, 30)).all() and (image[~shown] == 0).all()
    assert depth[shown] == pytest.approx(2.0, abs=1e-6)     # of the face ahead


def test_distortion_moves_pixels_as_its_model_says():
    lens, (x, y) = Distortion(-0.2, 0.03, 0.01, -0.02, 0.0), (0.4, -0.3)
    image, depth = seen(lens, visual(Shape(SPHERE, (0.1,)), at(4, -4 * x, -4 * y), RED),
                        fov=1.2)
    square = x * x + y * y
    factor = 1 + lens.k1 * square + lens.k2 * square ** 2
    moved = (x * factor + 2 * lens.p1 * x * y + lens.p2 * (square + 2 * x * x),
             y * factor + lens.p1 * (square + 2 * y * y) + 2 * lens.p2 * x * y)
    focal = SIZE[0] / 2 / math.tan(0.6)
    place = 159.5 + focal * moved[0], 119.5 + focal * moved[1]
    assert centroid(image) == pytest.approx(place, abs=0.3)
    # along the optical axis
    assert depth[round(place[1]), round(place[0])] == pytest.approx(3.91, abs=0.03)


@pytest.mark.parametrize('name', ['round', 'custom', 'equidistant'])
def test_sky_and_floor_join_in_all_faces(name):
    renderer = loaded(scene(floor=True, around=Surroundings(has_sky=True)), HERE)
    camera = Camera(*SIZE, 1.0, 0.05, 50.0, LENSES[name])
    pose = matrices.from_poses(np.array([[0.0, 0, 1, *rotations.quaternion_of(
        rotations.from_rpy((0.3, 0.4, 0.5)))]]))[0]
    image = lens_views.draw(renderer, camera, pose, HERE)
    right, down, ahead = np.moveaxis(directions(camera), -1, 0)
    ways = np.stack([ahead, -right, -down], axis=-1) @ pose[:3, :3].T
    height, expected = ways[..., 2], sky_color(ways)
    above, below = height > 0.02, height < -0.15
    assert np.abs(image[above] - expected[above]).max() < 4
    assert np.ptp(image[below], axis=1).max() <= 1      # grey, unlike the sky
    assert (image[np.isnan(height)] == 0).all()
