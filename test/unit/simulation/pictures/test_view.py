"""Where the simulation is seen from."""
import numpy as np
import pytest

from img_recog.rotations import transform
from img_recog.simulation.physics.body import BodyPose
from img_recog.simulation.pictures import view
from img_recog.simulation.pictures.view import ABOVE, follow
from img_recog_helpers import robots, sdf


def shelf(x, y, z=1.0, *size):
    """Return a static box; size: in m, 0.2 high and 0.8 in each direction by default."""
    sides = (*size, *(0.8, 0.8, 0.2)[len(size):])
    return sdf.body('shelf{}{}'.format(x, y), '{} {} {}'.format(x, y, z), sdf.box(*sides), True)


LEFT = (0.0, 0.0, np.sqrt(0.5), np.sqrt(0.5))       # a quarter turn


def above(*inside):
    return view.above(sdf.world(*inside))


def camera(pose):
    return '<gui><camera name="user_camera"><pose>{}</pose></camera></gui>'.format(pose)


@pytest.mark.parametrize('pose', [
    '0.8 0 12 0 1.5708 0', '0 0 17 0 1.5708 0', '2.7696 -1.93094 6.71513 0 1.1618 2.27182',
    '1 2 17 0 1.5708 1.0'])
def test_the_view_above_is_that_of_gazebos_user_camera(pose):
    numbers = tuple(map(float, pose.split()))
    found, wanted = above(camera(pose)).pose(), transform(numbers[:3], numbers[3:])
    assert found[:3, 3] == pytest.approx(wanted.translation, abs=0.01)
    assert found[:3, :3] == pytest.approx(wanted.rotation, abs=1e-3)


# that looks upward or is far away, over a shelf, or from below the floor
@pytest.mark.parametrize('pose, models, distance', [
    ('0 0 1 0 -0.5 0', '', 50.0), ('0 0 1e5 0 1.5708 0', '', 50.0),
    ('0 0 5 0 1.5708 0', shelf(1, 2), 6), ('0 0 5 0 1.5 0', shelf(1, 2), 5.0125),
    ('0 0 -1 0 1.5708 0', '', 0.5), ('0 0 5 0 1.5708 1', shelf(1, 2), 5)])
def test_how_far_away_a_user_camera_is(pose, models, distance):
    found = above(camera(pose), models)
    assert found.distance == pytest.approx(distance, rel=1e-3)
    if pose.endswith(' 1'):
        assert found.yaw == pytest.approx(np.degrees(1) - 90, abs=0.01)


def test_without_a_user_camera_it_shows_all_that_stands_in_the_world():
    assert above(sdf.BUILT_IN) == above(shelf(-3, 0), shelf(4, 5)) == ABOVE
    # to 4.7 m from x 0.8, and to 6.3 m from y 0
    for place in ((4.4, 0), (0, 5.7), (0, -5.7)):
        assert above(shelf(*place)) == ABOVE
    for place in ((-3.6, 0), (5.5, 0), (0, 6.3), (0, -6.3)):
        assert above(shelf(*place)) == ABOVE._replace(target=(
            pytest.approx(place[0], abs=0.01), pytest.approx(place[1], abs=0.01), 0.0))
    found = above(shelf(-3, 0), shelf(9, 6))
    assert found == ABOVE._replace(target=(pytest.approx(3.0, abs=0.1), pytest.approx(
        3.0, abs=0.1), 0.0), distance=16.0)
    assert above(shelf(-300, 0), shelf(90, 60)).distance == 300.0
    assert above(shelf(0, 0, 0, 99, 99, 0.01)) == ABOVE
    assert above(shelf(0, 0, 0, 99, 99, 0.1)).distance > 50


@pytest.mark.parametrize('pose, far', [
    ((0.8, 0, 12, 0, 1.5708, 0), 60), ((57.5, -14.75, 58.9, 0, 0.8516, 2.54), 132.41),
    ((0, 0, 100, 0, 1.5708, 0), 105), ((0, 0, 2, 0, 0, 0), 1000), ((0, 0, 2, 0, -1, 0), 1000)])
def test_the_picture_reaches_to_the_floor_in_all_of_it(pose, far):
    slope = np.tan(np.radians(30))
    found = view.near_and_far(transform(pose[:3], pose[3:]).matrix(), (slope, slope * 0.75))
    assert found == pytest.approx((far / 1200, far), rel=1e-4)


@pytest.mark.parametrize('boxes, height', [
    ([(0, 0, 6, 9, 9), (0, 0, 0.8, 9, 9, 0.1), (0, 0, 3, 9, 9)], 2.88),
    ([(0, 0, 1.9, 9, 9)], 1.78),
    ([(0, 0, 2, 2.4, 2.4)], 1.88),      # to 1.2 m on each side
    ([], np.inf), ([(0, 0, 0.8, 9, 9, 0.1)], np.inf),       # a table
    ([(0, 0, 2, 0.5, 9)], np.inf), ([(20, 0, 3, 9, 9)], np.inf),        # a beam; beside it
    *(([(x, y, 2, 9, 9)], np.inf) for x, y in ((-3.6, 0), (3.6, 0), (0, -3.6), (0, 3.6)))])
def test_the_view_ends_under_the_lowest_roof_above_a_robot(boxes, height):
    shelves = (shelf(*box).replace('shelf', 'shelf{}'.format(number))
               for number, box in enumerate(boxes))
    simulator = robots.assemble(sdf.sdf(*shelves))
    assert view.ceiling(simulator.world, [simulator.robots[0].body]) == pytest.approx(
        height, abs=0.01)


def test_the_pose_of_a_viewpoint():
    pose = ABOVE.pose()
    # at (0.8, 0, 12); its x axis leads down, its z axis, upward in the image, along the world's x
    assert pose[:3, 3] == pytest.approx([0.8, 0, 12], abs=0.01)
    assert pose[:3, 0] == pytest.approx([0, 0, -1], abs=1e-3)
    assert pose[:3, 2] == pytest.approx([1, 0, 0], abs=1e-3)
    behind = follow(BodyPose((1.0, 2.0, 0.0), LEFT, ())).pose()
    # it looks along the body's heading, the world's y, and down
    assert behind[:3, 3] == pytest.approx(
        [1, 2 - 1.3 * np.cos(np.radians(68)), 1.3 * np.sin(np.radians(68))], abs=1e-3)
    assert behind[:3, 0] == pytest.approx([0, np.cos(np.radians(68)), -np.sin(np.radians(68))],
                                          abs=1e-3)
    assert behind[:3, 1] == pytest.approx([-1, 0, 0], abs=1e-3)


def test_field_of_view_is_60_degrees_at_4_to_3():
    assert np.degrees(view.horizontal_fov(640, 480)) == pytest.approx(60, abs=0.1)
    assert np.degrees(view.horizontal_fov(480, 480)) == pytest.approx(46.8)
