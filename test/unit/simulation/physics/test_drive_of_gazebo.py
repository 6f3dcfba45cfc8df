"""The burger with the tags of the official one, against where Gazebo 11 has it after commands.

The wheels were turned there like libgazebo_ros_diff_drive turns them.
"""
import math

import pytest

from img_recog import rotations
from img_recog_helpers.robots import burger
from img_recog_helpers.wheeled import assembled, plugin

DRIVE = plugin(
    'gazebo_ros_diff_drive', leftJoint='wheel_left_joint', rightJoint='wheel_right_joint',
    wheelSeparation=0.16, wheelDiameter=0.066, wheelAcceleration=1, wheelTorque=10, updateRate=30)
FIRST = ''.join('<gazebo reference="wheel_{}_link"><fdir1>1 0 0</fdir1></gazebo>'.format(side)
                for side in ('left', 'right'))


@pytest.mark.parametrize('tags, parts, figures', [
    # how far it goes from place to place, or how far it turns, on the command, and until it stands
    # how far it slides then depends on the angle at which the wheels stop
    (FIRST, [(0.22, 0, 5)], [1.0640]),
    ('', [(0.22, 0, 5), (0, 0, 2)], [1.0696, 0.0245]),
    ('', [(0, 1, 5), (0, 0, 2)], [4.9604, 0.0334]),
    (FIRST, [(-10, 0, 2), (0, 0, 4)], [1.2496, 2.2980]),
    ('', [(-10, 0, 2), (0, 0, 4)], [1.9072, 2.0725])])
def test_ways(tags, parts, figures):
    simulator = assembled(burger('').replace('</robot>', DRIVE + tags + '</robot>'))
    robot = simulator.robots[0]
    simulator.advance(1000)
    for (forward, turn, seconds), figure in zip(parts, figures):
        robot.command(forward, turn)
        begin, turned = robot.body.motion(), 0.0
        for _ in range(seconds):
            before = robot.body.motion().yaw
            simulator.advance(1000)
            turned += math.remainder(robot.body.motion().yaw - before, 2 * math.pi)
        way = math.dist(robot.body.motion().position, begin.position)
        if parts[0][0]:
            assert way == pytest.approx(figure, rel=0.035, abs=0.005)
        else:
            assert turned == pytest.approx(figure, rel=0.02, abs=0.01) and way < 0.02


def test_how_it_stands():
    """Its wheels are as deep in the floor as their tags allow, its caster is on it."""
    sinking = ''.join('<gazebo reference="wheel_{}_link"><kp>500000.0</kp><kd>10.0</kd><minDepth>'
                      '0.001</minDepth></gazebo>'.format(side) for side in ('left', 'right'))
    robot = assembled(burger().replace('</robot>', sinking + '</robot>'))
    robot.advance(1000)
    pose = robot.robots[0].body.pose()
    assert pose.position[2] == pytest.approx(-0.001, abs=1e-4)
    assert -rotations.matrix(pose.orientation)[2, 0] == pytest.approx(0.0077, abs=0.002)


@pytest.mark.parametrize('angle, way', [
    (0.0, 0.0244), (22.5, 0.0277), (45.0, 0.0372), (67.5, 0.0661), (90.0, 0.1905),
    (112.5, 0.0548), (135.0, 0.0315), (157.5, 0.0252)])
def test_locked_wheels_slide_by_the_angle_of_their_direction_of_friction(angle, way):
    """So the way after a command of 0 depends on the angle at which the wheels stop."""
    direction = '{} {} 0'.format(math.cos(math.radians(angle)), math.sin(math.radians(angle)))
    tags = ''.join(
        '<gazebo reference="wheel_{}_link"><fdir1>{}</fdir1><kp>500000.0</kp><kd>10.0</kd>'
        '<minDepth>0.001</minDepth><maxVel>0.1</maxVel></gazebo>'.format(side, direction)
        for side in ('left', 'right'))
    simulator = assembled(burger('').replace('</robot>', DRIVE + tags + '</robot>'))
    robot = simulator.robots[0].body
    begin = robot.motion().position
    robot.set_velocity((0.22, 0.0, 0.0), (0.0, 0.0, 0.0))
    simulator.advance(1000)
    assert math.dist(robot.motion().position, begin) == pytest.approx(way, rel=0.05, abs=0.001)
