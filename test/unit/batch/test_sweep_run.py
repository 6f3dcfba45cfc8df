"""One run of a sweep: how it ends, what it depends on, and its film."""
import math

import pytest

from img_recog.batch import sweep_run
from img_recog.batch.sweep_file import Run, Success
from img_recog.errors import UserError
from img_recog.replay.chain import FrameResult
from img_recog.simulation.physics.body import Motion
from img_recog_helpers import pages, sdf
from img_recog_helpers.robots import assemble

POST = ('<model name="{}"><static>1</static><pose>{} 0 0.15 0 0 0</pose><link name="l">'
        '<collision name="c"><geometry><cylinder><radius>0.06</radius><length>0.3</length>'
        '</cylinder></geometry></collision><visual name="v"><geometry><cylinder>'
        '<radius>0.06</radius><length>0.3</length></cylinder></geometry><material><script>'
        '<name>Gazebo/{}</name></script></material></visual></link></model>')
CAMERA = {'camera_width': 160, 'camera_height': 120, 'camera_rate': 10.0}


@pytest.fixture
def field(tmp_path):
    """A blue post 0.9 m ahead of the origin."""
    path = tmp_path / 'field.world'
    path.write_text(sdf.sdf(sdf.BUILT_IN, POST.format('blue_post', 0.9, 'Blue')))
    return str(path)


def run(world, limit_s=6.0, success=Success(0.7), seed=1, **parameters):
    values = {'world': world, 'goal': 'blue*', 'x_pos': 0.0, 'y_pos': 0.0,
              'colors': pages.ROOT + '/config/follow.yaml', **CAMERA, **parameters}
    return sweep_run.run((), (), Run('run#1', {}, seed, values), success, limit_s)


def test_the_follower_reaches_a_post_ahead(field):
    result = run(field)
    assert (result.reason, result.collisions) == (sweep_run.REACHED, 0)
    assert result.distance_m == pytest.approx(0.7, abs=0.03) and 0.8 < result.time_s < 2
    assert result.path_m == pytest.approx(0.2, abs=0.03)
    assert result.x_m == pytest.approx(0.9 - result.distance_m, abs=0.01)


@pytest.mark.parametrize('reason, options', [
    (sweep_run.TIME, {'limit_s': 0.5}), (sweep_run.TIME, {'light_exposure': 0.02, 'limit_s': 2.0}),
    (sweep_run.PATH, {'success': Success(0.7, path_length=0.1)}),
    (sweep_run.TIME, {'max_linear_velocity': 0.01, 'limit_s': 2.0})])
def test_what_it_fails_by(field, reason, options):
    assert run(field, **options).reason == reason


def test_a_collision_ends_it_and_is_named(tmp_path):
    path = tmp_path / 'a.world'
    path.write_text(sdf.sdf(sdf.BUILT_IN, POST.format('blue_post', 0.9, 'Blue')
                            + POST.format('pillar', 0.3, 'White')))
    drive = tmp_path / 'drive.yaml'
    drive.write_text('{colors: [all], all_hue_min: 0, all_hue_max: 180, all_saturation_min: 0, '
                     'all_value_min: 0, all_area_limit: 0, all_linear_x: 0.2}')
    result = run(str(path), colors=str(drive))
    assert (result.reason, result.collisions, result.touched) == (
        sweep_run.COLLISION, 1, 'pillar')


def test_touches_between_two_images_are_counted(tmp_path):
    path = tmp_path / 'a.world'
    path.write_text(sdf.sdf(sdf.BUILT_IN, POST.format('pillar', 0.25, 'White')))
    simulator = assemble(str(path))
    robot, = simulator.robots
    judge = sweep_run.Judge(simulator, 'pillar', Success(0.01, collisions=9))
    for speed, steps in 2 * ((0.2, 1500), (-0.2, 1000)):
        robot.command(speed, 0)
        simulator.advance(steps)
    assert simulator.touched(robot.body) == []
    judge.on_frame(FrameResult(None, 4 * 10 ** 9, [], [], [], robot.body.motion()))
    assert (judge.result.collisions, judge.result.touched) == (2, 'pillar')


def test_a_film_of_the_same_run(field):
    values = {'world': '', 'goal': 'blue*', 'x_pos': 0.0, 'y_pos': 0.0, **CAMERA}
    film = sweep_run.film((field,), ('world',), Run('run#1', {}, 1, values), Success(0.7), 0.3)
    assert film[4:8] == b'ftyp'


def test_a_world_without_the_goal(field):
    with pytest.raises(UserError, match='the world has no model red; it has blue_post'):
        run(field, goal='red')


@pytest.mark.parametrize('position, speed', [((0, 0, -11), 0), ((math.nan, 0, 0), 0),
                                             ((0, 0, 0), 101)])
def test_a_robot_that_is_thrown_is_a_problem(field, position, speed):
    judge = sweep_run.Judge(assemble(field), 'blue*', Success())
    motion = Motion(position, (0, 0, 0, 1), (speed, 0, 0), (0, 0, 0))
    with pytest.raises(UserError, match='has thrown the robot: at 2.00 s'):
        judge.on_frame(FrameResult(None, 2 * 10 ** 9, [], [], [], motion))
