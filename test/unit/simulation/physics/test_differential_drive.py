"""The ramp of the wheel speeds, with ideal wheels in place of the physics."""
import dataclasses

import pytest

from img_recog.simulation.physics.differential_drive import DifferentialDrive
from img_recog.simulation.physics.robot import Motors
from img_recog_helpers.robots import burgers_drive

RADIUS = 0.033


class Wheels:
    """A robot with two ideal wheels: they have the velocities that are set, in rad/s."""

    def __init__(self, *velocities):
        self.velocities = velocities

    def wheel_velocities(self):
        return self.velocities

    wheel_positions = wheel_velocities

    def set_wheel_velocities(self, velocities):
        self.velocities = tuple(velocities)


def follow(drive, updates, start=(0.0, 0.0), robot=None):
    """Return the speeds of the wheel rims after each update, m/s."""
    robot, history = robot or Wheels(*start), []
    for _ in range(updates):
        drive.update(robot)
        history.append(tuple(velocity * RADIUS for velocity in robot.velocities))
    return history


def speeds_after(updates, linear, angular=0.0, **settings):
    """Return the speeds of the rims, from rest, so many updates after a command."""
    drive = DifferentialDrive(burgers_drive(**settings))
    drive.command(linear, angular)
    return follow(drive, updates)[-1]


class Slipping(Wheels):
    """Wheels that get a quarter of what they lack from one update to the next; asked: in m/s."""

    asked = 0.0

    def wheel_velocities(self):
        self.velocities = tuple(now + (self.asked / RADIUS - now) / 4 for now in self.velocities)
        return self.velocities

    def set_wheel_velocities(self, velocities):
        self.asked = velocities[0] * RADIUS


AT_ONCE = {'wheel_acceleration': 0.0}


@pytest.mark.parametrize('updates, command, settings, wanted', [
    # one meter per second squared
    (1, (10.0, 0.0), {}, (0.01, 0.01)), (50, (10.0, 0.0), {}, (0.5, 0.5)),
    (20, (0.105, 0.0), {}, (0.105, 0.105)), (100, (0.0, 1.0), {}, (-0.08, 0.08)),
    # of two wheels, the left one is at its target: both are set
    (1, (0.5, 0.5 / 0.08), {}, (0.0, 1.0)), (1, (10.0, 0.0), AT_ONCE, (10.0, 10.0)),
    # after a timeout, it brakes from where the ramp ended, one step before its target
    (60, (0.3, 0.0), {'cmd_vel_timeout': 0.5}, (0.19, 0.19)),
    # the ramp of half the default has steps of 0.005 m/s, and ends near the target
    *((1, (speed, 0.0), {'wheel_acceleration': 0.5}, (first, first)) for speed, first in (
        (0.01, 0.005), (0.0099, 0.0099), (-0.0099, -0.0099), (-0.01, -0.005), (0.5, 0.005)))])
def test_the_ramp(updates, command, settings, wanted):
    assert speeds_after(updates, *command, **settings) == pytest.approx(wanted)


@pytest.mark.parametrize('limits, command, wanted', [
    *(((0.22, 2.0), command, wanted) for command, wanted in (
        ((1.0, 0.0), (0.22, 0.22)), ((-1.0, 0.0), (-0.22, -0.22)),
        ((0.0, 9.0), (-0.16, 0.16)), ((0.0, -9.0), (0.16, -0.16)),
        ((0.21, 1.9), (0.058, 0.362)), ((9.0, -9.0), (0.38, 0.06)))),
    # zero means no limit
    ((0.22, 0.0), (9.0, 10.0), (-0.58, 1.02)), ((0.0, 2.0), (9.0, 10.0), (8.84, 9.16)),
    ((0.0, 0.0), (9.0, 10.0), (8.2, 9.8))])
def test_speeds_are_limited(limits, command, wanted):
    limits = dict(zip(('max_linear_velocity', 'max_angular_velocity'), limits))
    assert speeds_after(1, *command, **AT_ONCE, **limits) == pytest.approx(wanted)


def test_the_ramp_of_wheels_that_slip_goes_beyond_its_target_and_there_the_next_one_begins():
    drive, robot = DifferentialDrive(burgers_drive()), Slipping(0.0, 0.0)

    def asked(updates):
        follow(drive, updates, robot=robot)
        return pytest.approx(robot.asked)

    drive.command(0.1, 0.0)
    assert (asked(10), asked(2), asked(3)) == (0.1, 0.12, 0.1)
    drive.command(0.0, 0.0)
    assert asked(1) == 0.11


def test_braking_is_no_faster_than_driving_off():
    drive = DifferentialDrive(burgers_drive())
    drive.command(1.0, 0.0)
    follow(drive, 200)
    drive.command(-1.0, 0.0)
    speeds = follow(drive, 10, start=(1 / RADIUS, 1 / RADIUS))
    assert speeds[-1] == pytest.approx((0.89, 0.89))


def test_reset_forgets_the_command():
    drive = DifferentialDrive(burgers_drive())
    drive.command(10.0, 0.0)
    follow(drive, 20)
    drive.reset()
    assert follow(drive, 3)[-1] == (0.0, 0.0)


# as floats, 0.07 and 0.14 are slightly larger than 7 * 0.01 and 14 * 0.01
@pytest.mark.parametrize('timeout_s, updates', [
    (0.05, 5), (0.07, 7), (0.14, 14), (0.5, 50), (0.054, 6), (0.001, 1)])
def test_command_ends_after_the_timeout(timeout_s, updates):
    drive = DifferentialDrive(burgers_drive(wheel_acceleration=0.0, cmd_vel_timeout=timeout_s))
    drive.command(0.2, 0.0)
    speeds = follow(drive, updates + 3)
    assert speeds[updates - 1] == pytest.approx((0.2, 0.2))
    assert speeds[updates:] == [(0.0, 0.0)] * 3


def test_new_command_restarts_the_timeout():
    drive = DifferentialDrive(burgers_drive(wheel_acceleration=0.0, cmd_vel_timeout=0.05))
    robot = Wheels(0.0, 0.0)
    for _ in range(4):
        drive.command(0.2, 0.0)
        assert follow(drive, 4, robot=robot) == [pytest.approx((0.2, 0.2))] * 4
    assert follow(drive, 2, robot=robot) == [pytest.approx((0.2, 0.2)), (0.0, 0.0)]
    drive.command(0.1, 0.0)
    assert follow(drive, 1)[-1] == pytest.approx((0.1, 0.1))


@pytest.mark.parametrize('speed', [0.2, 0.0])
def test_a_timeout_is_reported_if_it_stops_the_robot(speed):
    drive = DifferentialDrive(burgers_drive(wheel_acceleration=0.0, cmd_vel_timeout=0.05))
    drive.command(speed, 0.0)
    follow(drive, 5)
    assert not drive.timed_out
    follow(drive, 10)
    assert drive.timed_out is (speed != 0.0)
    drive.command(0.2, 0.0)
    assert not drive.timed_out
    follow(drive, 6)
    drive.reset()
    assert not drive.timed_out


def test_a_timeout_that_is_scaled_is_that_many_times_as_long():
    drive = DifferentialDrive(burgers_drive(wheel_acceleration=0.0, cmd_vel_timeout=0.05))
    for factor, periods in ((4.0, 20), (1.0, 5)):       # not 4 times 1
        drive.scale_timeout(factor)
        drive.command(0.2, 0.0)
        assert follow(drive, periods)[-1] == pytest.approx((0.2, 0.2))
        assert follow(drive, 1) == [(0.0, 0.0)]


def test_timeout_of_zero_means_no_timeout():
    drive = DifferentialDrive(burgers_drive(wheel_acceleration=0.0))
    drive.scale_timeout(100.0)
    drive.command(0.2, 0.0)
    assert follow(drive, 100000)[-1] == pytest.approx((0.2, 0.2))


# left radius 0.11 m, right 0.09 m, and 0.6 m between them
UNEVEN = burgers_drive(
    left_joint='a, b', right_joint='c', wheel_separation=0.4, wheel_separation_multiplier=1.5,
    wheel_diameter=0.2, left_wheel_radius_multiplier=1.1, right_wheel_radius_multiplier=0.9,
    wheel_torque=7.0, wheel_acceleration=0.0)


def test_sides_that_differ():
    drive, robot = DifferentialDrive(UNEVEN), Wheels(1.0, 2.0, 4.0)
    assert drive.encoders(robot) == pytest.approx((1.5 * 0.11, 4.0 * 0.09))
    drive.command(0.5, 2.0)
    drive.update(robot)
    assert robot.velocities == pytest.approx((-0.1 / 0.11, -0.1 / 0.11, 1.1 / 0.09))
    assert drive.travelled((1.0, 2.0), (1.5, 2.2)) == pytest.approx((0.35, 0.0, -0.5))


@pytest.mark.parametrize('left, right', [('a', 'b'), ('a, b', 'c'), ('a', 'b, c')])
def test_what_drives_the_robot(left, right):
    motors = DifferentialDrive(dataclasses.replace(
        UNEVEN, left_joint=left, right_joint=right)).motors
    assert motors == Motors((*(('left_joint', name) for name in left.split(', ')),
                             *(('right_joint', name) for name in right.split(', '))),
                            7.0)


def test_a_ramp_after_a_reset_begins_at_zero():
    drive = DifferentialDrive(burgers_drive())
    drive.command(1.0, 0.0)
    follow(drive, 20)
    drive.reset()
    drive.command(1.0, 0.0)
    assert follow(drive, 1)[-1] == pytest.approx((0.01, 0.01))


def test_motors_are_set_when_the_speed_changes_or_something_has_stopped_them():
    drive, robot = DifferentialDrive(burgers_drive(wheel_acceleration=0.0)), Wheels(0.0, 0.0)
    drive.command(0.2, 0.0)
    follow(drive, 2, robot=robot)
    robot.velocities = 9.0, 9.0
    follow(drive, 2, robot=robot)
    assert robot.velocities == (9.0, 9.0)
    drive.notify_stopped()
    assert follow(drive, 1, robot=robot)[-1] == pytest.approx((0.2, 0.2))
