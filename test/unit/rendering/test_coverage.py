"""Which part of an image boxes can cover."""
import math

import numpy as np
import pytest

from img_recog.rendering import coverage, matrices
from img_recog.rendering.camera import Camera

CAMERA = Camera(320, 240, math.radians(60))
NEAR = 0.1


def to_clip(pose=np.eye(4), camera=CAMERA):
    return matrices.perspective(camera.edges, NEAR, 100.0) @ matrices.view(pose)


def boxes(*bounds):
    return coverage.Boxes([(part, np.array(low, float), np.array(high, float))
                           for part, low, high in bounds])


def seen(low, high, pose=np.eye(4)):
    corners = boxes((-1, low, high)).in_world(np.zeros((0, 4, 4)))
    return coverage.rectangles(corners, to_clip(pose), NEAR)[0]


def test_a_point_before_the_camera_has_a_negative_z_in_its_view():
    pose = matrices.from_poses(np.array([[1.0, -2.0, 0.5, 0.1, -0.3, 0.3, 0.9]]))[0]
    # x forward, y to the left, z up becomes x to the right, y up, z backward
    assert np.allclose(matrices.view(pose) @ pose @ (4.0, 1.0, 2.0, 1.0), (-1.0, 2.0, -4.0, 1.0))
    assert np.allclose(matrices.inverse(pose) @ pose, np.eye(4))


def test_a_box_ahead():
    # the near face decides: its half width is 1 at 2 m, where the image is 2 tan(30 deg) wide
    _, slope_x, _, slope_y = CAMERA.edges
    assert seen((2, -1, -0.5), (3, 1, 0.25)) == pytest.approx(
        [-0.5 / slope_x, -0.25 / slope_y, 0.5 / slope_x, 0.125 / slope_y])


def test_a_box_behind_is_not_seen():
    assert seen((-3, -1, -1), (-2, 1, 1))[0] == np.inf
    assert seen((-3, -1, -1), (NEAR * 0.99, 1, 1))[0] == np.inf


def test_a_box_around_the_camera_covers_all():
    found = seen((-1, -1, -1), (2, 1, 1))
    assert np.all(found[:2] < -1) and np.all(found[2:] > 1)


def test_a_wall_beside_the_camera_is_cut_where_it_is_seen():
    # from -5 to 5 m along x, at 1 m to the left: the far end is in the image
    found = seen((-5, 1, -0.5), (5, 1.5, 0.5))
    assert found[0] < -1 and found[2] == pytest.approx(-1 / 5 / CAMERA.edges.right)


def test_boxes_move_with_their_parts():
    moved = matrices.from_poses(np.array([[0, 0, 0, 0, 0, 0, 1],
                                          [1, 2, 3, 0, 0, math.sqrt(0.5), math.sqrt(0.5)]]))
    corners = boxes((-1, (0, 0, 0), (1, 2, 3)), (1, (0, 0, 0), (1, 2, 3))).in_world(moved)
    assert corners.shape == (2, 8, 3)
    assert corners[0].min(axis=0).tolist() == [0, 0, 0]
    assert corners[0].max(axis=0).tolist() == [1, 2, 3]
    # turned to the left by 90 degrees
    assert corners[1].min(axis=0) == pytest.approx([-1, 2, 3])
    assert corners[1].max(axis=0) == pytest.approx([1, 3, 6])


def test_tiles_hold_all_that_is_seen_and_do_not_overlap():
    random = np.random.RandomState(3)
    for _ in range(200):
        pose = matrices.from_poses(np.array([[0, 0, 0, *_quaternion(random)]]))[0]
        lows = random.uniform(-3, 3, (4, 3))
        highs = lows + random.uniform(0, 2, (4, 3))
        found = coverage.rectangles(boxes(*((-1, low, high) for low, high in zip(lows, highs)))
                                    .in_world(np.zeros((0, 4, 4))), to_clip(pose), NEAR)
        tiles = coverage.runs(found, CAMERA.width, CAMERA.height)
        assert len(tiles) <= coverage.count_tiles(CAMERA.width, CAMERA.height)
        count = _count(tiles)
        assert count.max(initial=0) <= 1
        points = lows[:, np.newaxis] + random.uniform(0, 1, (4, 300, 3)) * (
            highs - lows)[:, np.newaxis]
        points[:, ::2, 1:] = np.where(random.uniform(size=(4, 150, 2)) < 0.5, lows[:, None, 1:],
                                      highs[:, None, 1:])      # on edges
        clip = points @ to_clip(pose)[:, :3].T + to_clip(pose)[:, 3]
        is_ahead, places = clip[..., 3] > NEAR, clip[..., :2] / clip[..., 3:]
        assert ((places >= found[:, None, :2] - 1e-9) & (
            places <= found[:, None, 2:] + 1e-9)).all(axis=2)[is_ahead].all()
        places = places[is_ahead]
        pixels = ((places[(np.abs(places) < 1).all(axis=1)] + 1) / 2
                  * (CAMERA.width, CAMERA.height)).astype(int)
        assert (count[pixels[:, 1], pixels[:, 0]] == 1).all()


def test_what_is_on_the_image():
    def on_image(*rectangle):
        return coverage.are_on_image(np.array([rectangle])).tolist() == [True]
    assert on_image(-5.0, -5.0, 5.0, 5.0) and on_image(0.9, -3.0, 2.0, -0.9)
    assert not on_image(1.1, -1.0, 2.0, 1.0) and not on_image(-1.0, -2.0, 1.0, -1.1)
    assert not on_image(np.inf, np.inf, -np.inf, -np.inf)


def test_no_tiles_where_nothing_is_seen():
    assert coverage.runs(np.array([[np.inf, np.inf, -np.inf, -np.inf]]), 64, 64).shape == (0, 4)
    assert coverage.runs(np.zeros((0, 4)), 64, 64).shape == (0, 4)
    assert coverage.rectangles(boxes().in_world(np.zeros((0, 4, 4))), to_clip(), NEAR).shape == (
        0, 4)


def test_neighboring_tiles_of_a_row_are_one_rectangle():
    # pixels 40 to 90 of 160, rows 70 to 75 of 100
    place = np.array([[-0.5, 0.4, 0.125, 0.5]])
    assert coverage.runs(place, 160, 100) == pytest.approx(
        np.array([[32 / 80 - 1, 64 / 50 - 1, 96 / 80 - 1, 96 / 50 - 1]]))


def test_tiles_hold_a_pixel_around():
    # pixels 64.5 to 95.5 of 160: 63.5 and 96.5 are in the tiles beside
    assert coverage.runs(np.array([[64.5 / 80 - 1, -1.0, 95.5 / 80 - 1, 1.0]]), 160, 32) == (
        pytest.approx(np.array([[32 / 80 - 1, -1.0, 128 / 80 - 1, 1.0]])))


@pytest.mark.parametrize('width, height', [(160, 33), (161, 32)])
def test_there_is_room_for_as_many_tiles_as_there_can_be(width, height):
    places = [[x / width * 2 - 1, -1, x / width * 2 - 1, 1] for x in range(16, width, 64)]
    assert len(coverage.runs(np.array(places), width, height)) == coverage.count_tiles(
        width, height)


def test_triangles_of_a_rectangle():
    corners = np.frombuffer(coverage.triangles(np.array([[0.0, 1.0, 2.0, 3.0]])), 'f4')
    assert corners.reshape(-1, 2).tolist() == [[0, 1], [2, 1], [0, 3], [0, 3], [2, 1], [2, 3]]


def _quaternion(random):
    values = random.normal(size=4)
    return values / np.linalg.norm(values)


def _count(tiles):
    """Return how often each pixel is covered."""
    count = np.zeros((CAMERA.height + coverage.TILE_PX, CAMERA.width + coverage.TILE_PX), int)
    for left, top, right, bottom in np.round(
            (tiles + 1) / 2 * np.tile([CAMERA.width, CAMERA.height], 2)).astype(int):
        count[top:bottom, left:right] += 1
    return count
