"""A drive with all sensors, compared with its recorded values: what no single test looks at."""
import numpy as np
import pybullet
import pytest

from img_recog.simulation.physics.client import link_indices
from img_recog_helpers import robots


@pytest.fixture(scope='module')
def drive():
    """Return the motions and the last reading of each sensor after each part of a drive."""
    simulator = robots.simulator('turtlebot3_world', -2.0, -0.5, 0.3)
    vehicle, found = simulator.vehicles[0], []
    for linear_x, angular_z, steps in ((0.2, 0.5, 700), (-10.0, -1.5, 400), (0.0, 0.0, 300)):
        vehicle.command(linear_x, angular_z)
        readings = simulator.advance(steps)
        found.append((vehicle.robot.motion(), {each.sensor: each for each in readings}))
    return found


def test_motions(drive):
    motions = [np.concatenate([motion.position, motion.orientation, motion.linear,
                               motion.angular]) for motion, _ in drive]
    assert np.array(motions) == pytest.approx(np.array(MOTIONS), abs=2e-4)


def test_readings(drive):
    for (_, readings), (times, joints, imu, scan) in zip(drive, READINGS):
        assert [readings[name].time_s for name in ('odometry', 'joint_states', 'imu', 'scan')
                ] == pytest.approx(times)
        states = readings['joint_states'].value
        assert states.names == ('wheel_right_joint', 'wheel_left_joint')
        assert [*states.positions, *states.velocities, *states.efforts] == pytest.approx(
            joints, abs=2e-3)
        value = readings['imu'].value
        assert [*value.angular_velocity, *value.linear_acceleration] == pytest.approx(
            imu, abs=2e-3)
        assert readings['scan'].value[::30] == pytest.approx(np.array(scan), abs=2e-3)


def test_links_are_undamped_and_have_the_friction_of_the_description():
    simulator = robots.simulator('turtlebot3_world', -2.0, -0.5)
    robot, client = simulator.vehicles[0].robot, simulator.world.physics_client_id
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
    for body in (simulator.world.floor, *simulator.world.bodies):
        for link in body.links:
            assert pybullet.getDynamicsInfo(body.body_id, link, physicsClientId=client)[1] == 1.0
    parameters = pybullet.getPhysicsEngineParameters(physicsClientId=client)
    assert parameters['fixedTimeStep'] == 0.001 and parameters['gravityAccelerationZ'] == -9.8


# recorded: position, orientation, linear and angular velocity
MOTIONS = [
    (-1.89581, -0.454366, -0.000462, -0.000156, -0.000518, 0.269394, 0.96303, 0.196002, -7.7e-05,
     -0.000256, 0.000385, 0.000536, 0.500057),
    (-1.90529, -0.462495, -0.000491, -0.00026, -0.000182, 0.288467, 0.95749, -0.239992, -5e-06,
     8.8e-05, 3.2e-05, -0.00206, -3.7e-05),
    (-1.92904, -0.478044, -0.000472, -0.000167, -0.000518, 0.288452, 0.957494, -1e-06, -1.1e-05,
     -2.6e-05, -3e-06, 0.000704, -9.3e-05)]
# times of odometry, joint states, IMU and scan; joint states; IMU; every 30th ray
READINGS = [
    ((0.693, 0.693, 0.7, 0.6),
     (4.28842, 2.99606, 7.27247, 4.84795, 0.000615, 0.001296),
     (0.000248, 0.000364, 0.499517, 0.04677, 0.054248, 9.8008),
     (0.829644, 1.6721, 2.28945, 1.29845, 1.09467, 0.735023, 0.622922, 0.697355, 1.17132, 2.36809,
      0.945423, np.inf)),
    ((1.089, 1.089, 1.1, 1),
     (3.87358, 2.56424, -6.96863, -6.96816, -0.007059, -0.007778),
     (-0.000195, -0.001896, 7.7e-05, -0.664402, 0.28365, 9.78982),
     (0.803445, 1.63111, 2.00796, 1.25142, 1.12416, 0.714591, 0.651568, 0.787117, 1.46803, 2.50444,
      np.inf, np.inf)),
    ((1.386, 1.386, 1.4, 1.4),
     (2.95749, 1.6482, -0.00013, 0.000338, 6e-06, -7.4e-05),
     (0.000248, 0.001135, 3.4e-05, 0.015757, -0.001725, 9.80405),
     (0.836733, 1.69257, 1.96808, 1.22314, 1.07448, 0.662846, 0.601295, 0.731104, 1.35835, 2.48823,
      np.inf, np.inf))]
# lateral and spinning, of each link
FRICTIONS = {
    'base': (1.0, 0.0),
    'wheel_left_link': (0.1, 0.0),
    'wheel_right_link': (0.1, 0.0),
    'caster_back_link': (0.1, 0.0),
}
