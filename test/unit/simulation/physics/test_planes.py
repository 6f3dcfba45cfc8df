"""Planes carry without end, where Gazebo 11 has them: figures of it."""
import pybullet
import pytest

from img_recog_helpers import sdf

GROUND = '<include><uri>model://ground_plane</uri>{}</include>'
PLANE = ('<collision name="c"><pose>{}</pose><geometry><plane><normal>{}</normal><size>2 2</size>'
         '</plane></geometry></collision>')
FLAT = PLANE.format('0 0 0 0 0 0', '0 0 1')


def inline(pose):
    return sdf.body('ground_plane', pose, '<plane/>', static=True)


def fallen(world, name, seconds):
    body, = [body for body in world.scenery if body.name == name]
    world.step(round(seconds / world.step_s))
    return body.pose().position


@pytest.mark.parametrize('models, ball, seconds, position', [
    ([GROUND.format('')], '0 0 1', 1, (0, 0, 0.1)),
    ([GROUND.format('<pose>0 0 1 0 0 0</pose>')], '0 0 3', 1.5, (0, 0, 1.1)),
    ([GROUND.format('<pose>0 0 0 0 0.2 0</pose>')], '0 0 1', 1.5, (0, 0, 0.1)),
    ([GROUND.format('<pose>0 0 -1 0 0 0</pose><name>second</name>'),
      inline('0 0 0.5')], '200 0 4', 1.5, (200, 0, 0.6)),
    ([inline('')], '200 0 1', 1, (200, 0, 0.1)),
    ([sdf.body('p', '0 0 2', '', inside=FLAT)], '6 0 4', 1.5, (6, 0, 2.1)),
    ([], '0 0 1', 1, (0, 0, -3.9049))])
def test_where_a_ball_comes_to_rest(models, ball, seconds, position):
    world = sdf.world(*models, sdf.body('ball', ball, sdf.ball(0.1)))
    assert fallen(world, 'ball', seconds) == pytest.approx(position, abs=4e-3)


def test_the_plane_of_what_moves_stays():
    world = sdf.world(sdf.body('p', '0 0 2', '', inside=FLAT))
    assert fallen(world, 'p', 1.5) == pytest.approx((0, 0, -9.0323), abs=1e-3)


@pytest.mark.parametrize('model, link, collision, normal, heights', [
    ('0 0 1 0.2 0.1 0', '', '', '0 0 1', (1, 1, 1)), ('', '0 0 1 0 0.2 0', '', '0 0 1', (1, 1, 1)),
    ('', '', '0 0 1 0.3 0 0', '0 0 1', (1, 1, 1)), ('0 0 1', '', '', '0 0 2', (0.5, 0.5, 0.5)),
    ('0 0 1', '0 0 1', '', '0.6 0 1.6', (1.25, 0.125, 1.25)),
    ('1 0 1 0 0 1.5708', '1 0 0.5', '1 0 0.25 0 0 0', '0.6 0 0.8', (2.1875, -0.0625, 2.1875)),
    ('1 0 1 0.3 0 0', '1 0 0.5 0 0.2', '1 0 0.25 0 0 0', '0.6 0 0.8', (1.9024, -0.3476, 1.9024))])
def test_no_pose_turns_a_plane_and_its_height_alone_moves_it(model, link, collision, normal,
                                                             heights):
    plane = PLANE.format(collision or '0 0 0 0 0 0', normal)
    world = sdf.world(sdf.model('p', sdf.link(pose=link, inside=plane), pose=model, static=True))
    found = pybullet.rayTestBatch([(x, y, 9) for x, y in ((0, 0), (3, 0), (0, 3))],
                                  [(x, y, -9) for x, y in ((0, 0), (3, 0), (0, 3))],
                                  physicsClientId=world.physics_client_id)
    assert [hit[3][2] for hit in found] == pytest.approx(heights, abs=1e-4)
