"""Resets of the simulator: the robot, the world, the time."""
import math

import pybullet
import pytest

from img_recog_helpers import sdf
from img_recog_helpers.robots import assemble, burgers


def test_reset_world_keeps_time_and_forgets_the_command():
    sim = assemble(x=-2.0)
    sim.robots[0].command(1.0, 0.5)
    sim.advance(2000)
    revision = sim.world.revision
    sim.reset_world()
    assert sim.world.revision == revision       # nothing to be drawn anew
    assert sim.robots[0].body.motion().position == pytest.approx([-2.0, 0.0, 0.0], abs=1e-6)
    assert sim.time_s == pytest.approx(2.0)
    sim.advance(1000)
    assert sim.robots[0].body.motion().position == pytest.approx([-2.0, 0.0, 0.0], abs=1e-3)


def test_a_robot_that_is_moved_stands_where_it_was_put():
    sim = assemble(x=-2.0)
    robot = sim.robots[0]
    robot.command(0.5, 1.0)
    sim.advance(1000)
    robot.move_to(1.0, -0.5, 2.0)
    assert robot.body.motion().position == pytest.approx([1.0, -0.5, 0.0], abs=1e-6)
    sim.advance(1)          # before the drive is due
    assert robot.body.wheel_velocities() == pytest.approx((0.0, 0.0), abs=0.5)
    sim.advance(1000)
    motion = robot.body.motion()
    assert motion.position == pytest.approx([1.0, -0.5, 0.0], abs=0.005)
    assert motion.yaw == pytest.approx(2.0, abs=0.02)
    robot.command(0.2, 0.0)
    sim.advance(2000)
    moved = robot.body.motion().position - motion.position
    assert moved[:2] == pytest.approx([0.38 * math.cos(2.0), 0.38 * math.sin(2.0)], abs=0.03)
    sim.reset_world()       # its start is still the first one
    assert robot.body.motion().position == pytest.approx([-2.0, 0.0, 0.0], abs=1e-6)


def test_reset_of_the_robot_stops_its_wheels():
    sim = assemble()
    robot = sim.robots[0].body
    sim.robots[0].command(0.2, 0.0)
    sim.advance(2000)
    assert min(robot.wheel_positions()) > 1.0
    robot.reset()
    assert robot.wheel_positions() == robot.wheel_velocities() == (0.0, 0.0)
    # without the robot, which sets the velocity of the motors in each step
    for _ in range(500):
        pybullet.stepSimulation(physicsClientId=robot.physics_client_id)
    assert robot.wheel_positions() == pytest.approx((0.0, 0.0), abs=0.01)


@pytest.mark.parametrize('reset', ['reset_world', 'reset_simulation'])
def test_reset_puts_the_bodies_of_the_world_back(reset):
    sim = assemble(sdf.sdf(sdf.body('crate', '1 2 0.5 0 0 0.3', sdf.box(0.1, 0.1, 0.1))))
    crate = sim.world.scenery[0]
    before = crate.motion()
    sim.advance(200)
    assert crate.motion().position[2] < 0.4 and crate.motion().linear[2] < -1
    getattr(sim, reset)()
    for got, wanted in zip(crate.motion(), before):
        assert got == pytest.approx(wanted, abs=1e-6)
    assert before.position == pytest.approx([1, 2, 0.5], abs=1e-6)


def test_after_a_reset_all_moves_and_is_measured_as_before():
    """To the last bit: what touches at the start touches as if for the first time."""
    crates = [sdf.body('crate{}'.format(number), '{} {} {} 0 0 0.{}'.format(
        0.4 + 0.07 * (number % 3), 0.08 * (number % 2), 0.05 + 0.095 * number, number),
        sdf.box(0.2, 0.2, 0.1)) for number in range(8)]
    sim = assemble(sdf.sdf(sdf.BUILT_IN, *crates), scan=burgers('scan', scan_noise=0.01),
                   imu=burgers('imu', gyro_noise=0.01, accel_noise=0.1))
    bodies = [sim.robots[0].body, *sim.world.scenery]

    def drive():
        sim.robots[0].command(0.2, 0.5)
        values = [each.value for each in sim.advance(2000) if each.kind in ('imu', 'scan')]
        return [body.pose() for body in bodies], repr(values)
    first = drive()
    sim.reset_simulation()
    assert drive() == first
    sim.robots[0].mounted.set_enabled('imu', False)
    sim.advance(107)        # at another phase of the drive and of the sensors
    sim.robots[0].mounted.set_enabled('imu', True)
    sim.reset_simulation()
    assert drive() == first
    sim.reset_world()       # only the noise goes on, as it does in Gazebo
    again = drive()
    assert again[0] == first[0] and again[1] != first[1]
    sim.advance(107)
    sim.reset_world()
    assert drive()[0] == first[0]


def test_reset_simulation_sets_the_time_to_zero():
    sim = assemble()
    sim.robots[0].command(1.0, 0.0)
    sim.advance(1000)
    sim.reset_simulation()
    assert sim.time_s == 0.0
    readings = sim.advance(33)
    assert [(each.sensor, each.time_s) for each in readings if each.sensor != 'imu'] == [
        ('odometry', pytest.approx(0.033)), ('joint_states', pytest.approx(0.033))]


def test_noise_after_a_reset_does_not_depend_on_whether_the_sensor_was_enabled_before():
    def measured(is_enabled):
        sim = assemble()
        sim.advance(100)
        sim.robots[0].mounted.set_enabled('imu', is_enabled)
        sim.advance(200)
        sim.reset_simulation()
        sim.advance(200)
        sim.robots[0].mounted.set_enabled('imu', True)
        return [each.value.angular_velocity for each in sim.advance(20)
                if each.sensor == 'imu']
    assert measured(False) == measured(True) and len(measured(True)) == 4
