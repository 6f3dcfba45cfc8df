"""Shadows: where they are, and that they do not depend on what was drawn before."""
import math

import numpy as np
import pytest

from img_recog.model import BOX, CYLINDER, Shape
from img_recog_testing.drawn import (BLUE, CAMERA, GREEN, HERE, RED, at, draw, loaded,
                                     looking_down, scene, visual)


def test_a_shadow_on_the_floor():
    tile = visual(Shape(BOX, (0.5, 0.5, 0.02)), at(0, 0, 1.0), RED)
    image = draw(tile, sun=(1, 0, 1), floor=True, pose=looking_down(8.0, x=-1.0))
    floor = 0.7 * 255
    lit, dark = floor * (0.75 + 0.25 * math.sqrt(0.5)), floor * (0.675 + 0.175 * math.sqrt(0.5))
    # the shadow of a tile at 1 m is 1 m behind it, in the middle of the image
    assert image[120, 160].tolist() == pytest.approx([dark] * 3, abs=1)
    fx = CAMERA.intrinsics.fx
    edge = round(0.25 * fx / 8)
    assert image[120, 160 + edge + 3].tolist() == pytest.approx([lit] * 3, abs=1)
    assert image[120, 160 + edge - 3].tolist() == pytest.approx([dark] * 3, abs=1)
    assert len(np.unique(image[120, 150:240, 1])) == 2      # nothing between


def test_what_moves_takes_its_shadow_with_it():
    poses = np.array([[0.0, 0, 1, 0, 0, 0, 1]])
    renderer = loaded(scene(visual(Shape(BOX, (0.5, 0.5, 0.02)), np.eye(4), RED), floor=True,
                            moving=(True,)), poses)
    down = looking_down(8.0)
    before = renderer.draw(CAMERA, down, poses)
    moved = poses + (1.0, 0, 0, 0, 0, 0, 0)
    after = renderer.draw(CAMERA, down, moved)
    shifted = renderer.draw(CAMERA, looking_down(8.0, x=1.0), moved)
    assert np.abs(shifted.astype(int) - before).max() <= 30       # at the edges of the shadow
    assert (shifted != before).mean() < 0.01
    assert not np.array_equal(before, after)
    assert np.array_equal(renderer.draw(CAMERA, down, poses), before)


def test_a_wall_throws_no_shadow_on_itself():
    wall = visual(Shape(BOX, (0.2, 4.0, 2.0)), at(5, 0, 0), (1.0, 1.0, 1.0, 1.0))
    image = draw(wall, sun=(-1, 0.1, 0.5))
    face = image[80:160, 60:260]
    assert face.min() == face.max()


def test_equal_scenes_and_poses_give_equal_bytes():
    visuals = [visual(Shape(CYLINDER, (0.2, 1.0)), at(3, 0, 0), GREEN, part=1),
               visual(Shape(BOX, (0.3, 8, 1)), at(6, 0, 0), BLUE)]
    poses = np.array([HERE[0], [0, 0.3, 0, 0, 0, 0.1, math.sqrt(0.99)]])
    content = scene(*visuals, sun=(0.5, -0.1, 0.9), floor=True, moving=(False, True))
    first, second = loaded(content, poses), loaded(content, poses)
    images = []
    for step in range(5):       # there and back
        moved = poses.copy()
        moved[1, 1] += 0.37 * step
        images.append(first.draw(CAMERA, at(0, 0, 0.5), moved))
    assert np.array_equal(first.draw(CAMERA, at(0, 0, 0.5), poses), images[0])
    assert np.array_equal(second.draw(CAMERA, at(0, 0, 0.5), poses), images[0])


def test_what_moves_through_the_shadow_of_another_part_leaves_it_there():
    # one is in the shadow of the other
    tiles = [visual(Shape(BOX, (0.5, 0.5, 0.02)), at(-0.5 * part, 0, height), RED, part)
             for part, height in enumerate((1.0, 0.5))]
    content = scene(*tiles, sun=(1, 0, 1), floor=True, moving=(True, True))
    apart = np.concatenate([HERE, HERE])
    apart[1, 1] = 3.0
    together, both = apart.copy(), apart.copy()
    together[1, 1], both[:, 1] = 0.2, (0.5, 0.7)
    renderer = loaded(content, apart)
    # only one of them moves at first, later both
    for poses in (apart, together, apart, both, together, apart):
        assert np.array_equal(renderer.draw(CAMERA, looking_down(8.0), poses),
                              loaded(content, poses).draw(CAMERA, looking_down(8.0), poses))


@pytest.mark.parametrize('cosine', [0.01, 0.03, 0.06, 0.1, 0.3])
def test_in_a_large_world_a_wall_along_the_light_has_no_stripes(cosine):
    sun = np.array([0.5, -0.1, 0.9]) / np.linalg.norm([0.5, -0.1, 0.9])
    angle = math.atan2(sun[1], sun[0]) + math.acos(cosine / math.hypot(*sun[:2]))
    # seen from 3 m in front of it
    wall, camera = at(0, 0, 4), at(3 * math.cos(angle), 3 * math.sin(angle), 1.2)
    for pose, heading in ((wall, angle), (camera, angle + math.pi + 0.4)):
        pose[:2, :2] = [[math.cos(heading), -math.sin(heading)],
                        [math.sin(heading), math.cos(heading)]]
    image = draw(visual(Shape(BOX, (60, 60, 0.1)), at(0, 0, -0.05), GREEN),
                 visual(Shape(BOX, (0.2, 20, 8)), wall, RED), sun=tuple(sun), pose=camera)
    assert np.ptp(image[:120, :, 0]) <= 1


@pytest.mark.parametrize('size', [(1, 90, 0.1), (90, 1, 0.1)])
def test_in_a_long_world_what_has_moved_leaves_no_shadow_behind(size):
    content = scene(visual(Shape(BOX, size), at(0, 0, -0.05), BLUE),
                    visual(Shape(BOX, (0.5, 0.5, 0.02)), at(0, 0, 1), RED, part=1), floor=True,
                    sun=(1, 0, 1), moving=(False, True))
    here, there = np.concatenate([HERE, HERE]), np.concatenate([HERE, HERE])
    there[1, :2] = 1.5, 1.0
    renderer = loaded(content, here)
    for poses in (here, there, here, there):
        assert np.array_equal(renderer.draw(CAMERA, looking_down(8.0), poses),
                              loaded(content, poses).draw(CAMERA, looking_down(8.0), poses))


def test_what_reaches_out_of_all_that_cannot_move_has_its_whole_shadow():
    image = draw(visual(Shape(BOX, (0.2, 0.2, 0.2)), np.eye(4), BLUE),
                 visual(Shape(BOX, (4, 4, 0.02)), at(3.5, 0, 1), RED, part=1), sun=(-1, 0, 1),
                 floor=True, moving=(False, True), poses=np.concatenate([HERE, HERE]),
                 pose=looking_down(4.0, x=6.0))
    assert image[120, 160, 1] == pytest.approx(
        0.7 * 255 * (0.675 + 0.175 * math.sqrt(0.5)), abs=1)


def _with_moved_tile(y, *others, sun, floor, place):
    """Return an image with the shadow of a red tile, which was elsewhere in the image before."""
    content = scene(visual(Shape(BOX, (0.5, 0.5, 0.02)), at(*place), RED, part=1), *others,
                    sun=sun, floor=floor, moving=(False, True))
    poses = np.concatenate([HERE, HERE])
    renderer = loaded(content, poses)
    for way in (1.0, y):
        poses[1, 1] = way
        image = renderer.draw(CAMERA, at(0, 0, 0.5), poses)
    assert not (image[..., 2] < 50).any()       # the tile itself is not seen
    return image


@pytest.mark.parametrize('y', [0.0, -0.5])
def test_what_is_not_on_the_image_throws_its_shadow_into_it(y):
    fx = CAMERA.intrinsics.fx
    column = round(160 - y / 3 * fx)
    floor = _with_moved_tile(y, sun=(0, 0, 1), floor=True, place=(3, 0, 3))[
        round(120 + 0.5 / 3 * fx)]
    assert floor[column, 0] == pytest.approx(0.7 * 255 * 0.85, abs=1)
    assert floor[160 + 80, 0] == floor[160 - 80, 0] == pytest.approx(0.7 * 255, abs=1)
    wall = _with_moved_tile(y, visual(Shape(BOX, (0.2, 4, 1.6)), at(4.1, 0, 0.8), BLUE),
                            sun=(-1, 0, 1), floor=False, place=(2.5, 0, 2.5))[
        round(120 - 0.5 / 4 * fx)]
    column, cosine = round(160 - y / 4 * fx), math.sqrt(0.5)
    assert wall[column, 2] == pytest.approx(255 * (0.675 + 0.175 * cosine), abs=1)
    assert wall[160 + 80, 2] == wall[160 - 80, 2] == pytest.approx(
        255 * (0.75 + 0.25 * cosine), abs=1)


def test_an_image_without_the_shadow_of_what_moved_leaves_those_of_others_right():
    content = scene(visual(Shape(BOX, (0.5, 0.5, 0.02)), at(0, 0, 1.0), RED, part=1),
                    visual(Shape(BOX, (0.5, 0.5, 0.02)), at(0, 1, 0.5), RED), sun=(1, 0, 1),
                    floor=True, moving=(False, True))
    poses = [np.concatenate([HERE, HERE + (0, y, 0, 0, 0, 0, 0)]) for y in (0.0, 0.4, 0.9)]
    down, away = looking_down(8.0), at(3, 0, 0.5)
    renderer = loaded(content, poses[0])
    for camera, number in ((down, 0), (away, 1), (down, 2), (away, 2), (away, 0), (down, 1),
                           (down, 0), (away, 2), (down, 2)):
        assert np.array_equal(renderer.draw(CAMERA, camera, poses[number]),
                              loaded(content, poses[number]).draw(CAMERA, camera, poses[number]))
