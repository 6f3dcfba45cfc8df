"""A drive with all sensors, compared with its recorded values: what no single test looks at."""
import os
import re

import numpy as np
import pybullet
import pytest

from img_recog.simulation.physics.client import link_indices
from img_recog_helpers import robots
from img_recog_helpers.pages import ROOT


def recorded():
    """Yield the values after each part of the drive by their names."""
    with open(os.path.join(ROOT, 'test', 'expected', 'drive.txt')) as file:
        for part in re.sub('(?m)^#.*\n', '', file.read()).split('\n\n'):
            yield {name: list(map(float, values))
                   for name, *values in map(str.split, part.splitlines())}


def test_motions_and_readings():
    simulator = robots.assemble('turtlebot3_world', -2.0, -0.5, 0.3)
    robot, = simulator.robots
    parts = list(recorded())
    assert len(parts) == 3
    for (linear_x, angular_z, steps), expected in zip(
            ((0.2, 0.5, 700), (-10.0, -1.5, 400), (0.0, 0.0, 300)), parts):
        robot.command(linear_x, angular_z)
        readings = {each.sensor: each for each in simulator.advance(steps)}
        assert np.concatenate(robot.body.motion()) == pytest.approx(
            expected['motion'], abs=2e-4)
        assert [readings[name].time_s for name in ('odometry', 'joint_states', 'imu', 'scan')
                ] == pytest.approx(expected['times'])
        states, imu, scan = (readings[name].value for name in ('joint_states', 'imu', 'scan'))
        assert states.names == ('wheel_right_joint', 'wheel_left_joint')
        for found, name in (
                ([*states.positions, *states.velocities, *states.efforts], 'joints'),
                ([*imu.angular_velocity, *imu.linear_acceleration], 'imu'), (scan[::30], 'scan')):
            assert found == pytest.approx(np.array(expected[name]), abs=2e-3), name


def test_links_are_undamped_and_have_the_friction_of_the_description():
    simulator = robots.assemble('turtlebot3_world', -2.0, -0.5)
    robot, client = simulator.robots[0].body, simulator.world.physics_client_id
    assert robot.mass() == pytest.approx(1.0017329, abs=1e-6)
    frictions = {}
    names = {link: name for name, link in link_indices(robot.body_id, client).items()}
    for link in robot.links:
        info = pybullet.getDynamicsInfo(robot.body_id, link, physicsClientId=client)
        name = 'base' if link == -1 else names[link]
        frictions[name] = info[1], info[7]
        if link != -1:
            assert pybullet.getJointInfo(robot.body_id, link, physicsClientId=client)[6] == 0
    assert frictions == FRICTIONS
    simulator.advance(1)        # of what never moves, the coefficient is at most 1 from then on
    for body in (simulator.world.floor, *simulator.world.scenery):
        for link in body.links:
            assert pybullet.getDynamicsInfo(body.body_id, link, physicsClientId=client)[1] == 1.0
    parameters = pybullet.getPhysicsEngineParameters(physicsClientId=client)
    assert parameters['fixedTimeStep'] == 0.001 and parameters['gravityAccelerationZ'] == -9.8


# lateral and spinning, of each link
FRICTIONS = {
    'base': (1.0, 0.0),
    'wheel_left_link': (0.1, 0.0),
    'wheel_right_link': (0.1, 0.0),
    'wheel_left_link::tread_0': (0.1, 0.0),
    'wheel_right_link::tread_0': (0.1, 0.0),
    'caster_back_link': (0.1, 0.0),
}
