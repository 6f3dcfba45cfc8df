"""check_robot.py and check_world.py as a user runs them: lines, exit codes, no master."""
import os

import pytest

from img_recog_testing.pages import ROOT
from img_recog_testing.robots import burger
from img_recog_testing.sdf import BOX, BUILT_IN, sdf

WALL = ('<model name="wall"><static>1</static><link name="l">'
        + BOX.format('visual', '', '0.1 4 2') + '</link></model>')
CHAIR = '<include><uri>model://chair</uri></include>'


@pytest.fixture
def run(ros, tmp_path):
    """A function that runs a program in a folder; it returns the exit code and the lines."""
    def start(*command):
        process = ros.start_node(*command, cwd=str(tmp_path))
        code = process.wait()
        return code, [line for line in process.output.splitlines()
                      if line and not line.startswith('pybullet build time')]
    return start


def test_a_robot_that_can_be_used(run, tmp_path):
    (tmp_path / 'my.urdf').write_text(burger().replace('imu_link', 'a_link'))
    code, lines = run('check_robot.py', 'my.urdf')
    assert code == 0 and lines[0] == 'robot turtlebot3_burger in my.urdf', lines
    words = [line.split() for line in lines]
    assert 'simulated wheel_diameter 0.066 m shapes of the wheels'.split() in words
    assert 'assumed command_topic cmd_vel default'.split() in words
    assert 'not simulated imu no link imu_link'.split() in words
    assert 'measured turning 0.500 rad/s asked 0.5 rad/s'.split() in words
    assert lines[-1] == (
        'warning: turtlebot3_burger runs without the sensor imu: no link imu_link')


def test_a_robot_that_cannot_be_used(run, tmp_path):
    (tmp_path / 'my.urdf').write_text('<robot name="r"><link name="a"/></robot>')
    assert run('check_robot.py', 'my.urdf') == (1, [
        'check_robot.py: cannot use the robot in my.urdf: link a can move but has no mass; add an '
        '<inertial> to it or to a link fixed to it'])


def test_a_world_with_and_without_what_it_includes(run, tmp_path):
    (tmp_path / 'whole.sdf').write_text(sdf(BUILT_IN, WALL))
    assert run('check_world.py', 'whole.sdf') == (0, [
        'world whole in whole.sdf',
        'state      what        value                                             from',
        'simulated  model wall  static, 0.1 x 4 x 2 m',
        'simulated  models      1, 0.1 x 4 x 2 m',
        'simulated  floor       at z 0, drawn',
        'simulated  gravity     0 0 -9.8 m/s2',
        'simulated  drawn       1 shapes, 12 triangles, 0 mesh files, 0 textures'])
    (tmp_path / 'part.sdf').write_text(sdf(BUILT_IN, WALL, CHAIR))
    code, lines = run('check_world.py', 'part.sdf')
    assert code == 1
    assert 'left out   model://chair  needs allow_partial_world:=true' in lines
    assert 'warning: world part.sdf: loaded without: model://chair' in lines
    assert ('check_world.py: something is left out of it; start it with '
            'allow_partial_world:=true') in lines
    assert run('check_world.py', '--allow-partial-world', 'part.sdf')[0] == 0


@pytest.mark.parametrize('program', ['check_robot.py', 'check_world.py'])
def test_wrong_usage_and_no_file(run, program):
    code, lines = run(program)
    assert code == 2 and lines[0].startswith('usage: ' + program), lines
    code, (line,) = run(program, 'none.urdf')
    assert code == 1 and line.startswith(program + ': ') and 'none.urdf' in line


@pytest.mark.parametrize('program, file', [('check_robot.py', 'turtlebot3_burger.urdf'),
                                           ('check_world.py', 'color_posts.sdf')])
def test_our_own_robot_and_world_can_be_used(run, program, file):
    code, lines = run(program, os.path.join(ROOT, 'urdf', file))
    assert code == 0 and not [line for line in lines if line.startswith('warning')], lines
