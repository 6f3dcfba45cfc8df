"""A drive with all sensors, compared with its recorded values: what no single test looks at."""
import numpy as np
import pybullet
import pytest

from img_recog.simulation.physics.client import link_indices
from img_recog_testing import robots


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
    frictions = {}
    names = {link: name for name, link in link_indices(robot.body_id, client).items()}
    for link in robot.links:
        info = pybullet.getDynamicsInfo(robot.body_id, link, physicsClientId=client)
        name = 'base' if link == -1 else names[link]
        frictions[name] = info[1], info[7]
        if link != -1:
            assert pybullet.getJointInfo(robot.body_id, link, physicsClientId=client)[6] == 0
    assert frictions == FRICTIONS
    for body in (simulator.world.floor, *simulator.world.bodies):
        for link in body.links:
            assert pybullet.getDynamicsInfo(body.body_id, link, physicsClientId=client)[1] == 1.0
    parameters = pybullet.getPhysicsEngineParameters(physicsClientId=client)
    assert parameters['fixedTimeStep'] == 0.001 and parameters['gravityAccelerationZ'] == -9.8


# recorded: position, orientation, linear and angular velocity
MOTIONS = [
    (-1.89891, -0.459144, -3e-06, 0.000639, -0.002518, 0.245867, 0.9693, 0.196008, -1.1e-05,
     -0.001019, 0.002598, 0, 0.499957),
    (-1.89416, -0.459793, -3e-06, 0.000831, -0.002462, 0.319896, 0.947449, -0.176953, -0.002259,
     0.00092, 0.001207, -2e-06, 0.232809),
    (-1.91111, -0.473351, -3e-06, 0.000935, -0.002424, 0.359714, 0.933059, -8e-06, -1e-06,
     2.4e-05, -6.8e-05, -0.00027, -1.7e-05)]
# times of odometry, joint states, IMU and scan; joint states; IMU; every 30th ray
READINGS = [
    ((0.693, 0.693, 0.7, 0.6),
     (4.31265, 2.9962, 7.27247, 4.84857, 0.001731, -0.000384),
     (0.00246, -0.000172, 0.499416, 0.089113, 0.059892, 9.80032),
     (0.848453, np.inf, 2.4817, 1.33607, 1.09441, 0.751022, 0.618516, 0.673209, 1.0718, 2.30509,
      0.918297, np.inf)),
    ((1.089, 1.089, 1.1, 1),
     (4.8408, 2.56437, -4.54562, -6.96972, -0.013115, -0.017194),
     (0.000979, 0.000162, 0.232923, -0.851241, 0.073375, 9.80024),
     (0.814887, 1.65767, 1.90878, 1.23521, 1.10986, 0.706198, 0.657875, 0.813686, 1.52375,
      2.57223, np.inf, 2.9609)),
    ((1.386, 1.386, 1.4, 1.4),
     (4.42411, 1.73316, -0.000625, -0.000647, -0.000203, -0.000203),
     (0.000183, 0.000161, 0.00011, 0.04843, 0.006375, 9.80996),
     (2.39846, 3.20845, 1.64677, 1.16968, 0.912721, 0.642569, 0.632961, 0.847422, 1.52801,
      2.80592, 1.8762, 1.86873))]
# lateral and spinning, of each link
FRICTIONS = {
    'base': (1.0, 0.0),
    'wheel_left_link': (0.1, 0.0004500000000000001),
    'wheel_right_link': (0.1, 0.0004500000000000001),
    'caster_back_link': (0.1, 0.0),
}
