"""The ramp of the wheel speeds, with ideal wheels in place of the physics."""
import dataclasses

import pytest

from img_recog.simulation.physics.drive import DifferentialDrive
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


class Slipping(Wheels):
    """Wheels that get a quarter of what they lack from one update to the next; asked: in m/s."""

    asked = 0.0

    def wheel_velocities(self):
        self.velocities = tuple(now + (self.asked / RADIUS - now) / 4 for now in self.velocities)
        return self.velocities

    def set_wheel_velocities(self, velocities):
        self.asked = velocities[0] * RADIUS


class Rig:
    def __init__(self, robot=None, **settings):
        self.drive = DifferentialDrive(burgers_drive(**settings))
        self.robot = robot or Wheels(0.0, 0.0)

    def after(self, updates, *command):
        """Return the speeds of the rims, m/s, so many updates after a command, if there is one."""
        if command:
            self.drive.command(*command)
        for _ in range(updates):
            self.drive.update(self.robot)
        return pytest.approx(tuple(velocity * RADIUS for velocity in self.robot.velocities))


AT_ONCE = {'wheel_acceleration': 0.0}


def limits(linear, angular):
    return {**AT_ONCE, 'max_linear_velocity': linear, 'max_angular_velocity': angular}


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
        (0.01, 0.005), (0.0099, 0.0099), (-0.0099, -0.0099), (-0.01, -0.005), (0.5, 0.005))),
    # velocities are limited
    *((1, command, limits(0.22, 2.0), wanted) for command, wanted in (
        ((1.0, 0.0), (0.22, 0.22)), ((-1.0, 0.0), (-0.22, -0.22)),
        ((0.0, 9.0), (-0.16, 0.16)), ((0.0, -9.0), (0.16, -0.16)),
        ((0.21, 1.9), (0.058, 0.362)), ((9.0, -9.0), (0.38, 0.06)))),
    # zero means no limit
    (1, (9.0, 10.0), limits(0.22, 0.0), (-0.58, 1.02)),
    (1, (9.0, 10.0), limits(0.0, 2.0), (8.84, 9.16)),
    (1, (9.0, 10.0), limits(0.0, 0.0), (8.2, 9.8))])
def test_the_speeds_after_a_command(updates, command, settings, wanted):
    assert Rig(**settings).after(updates, *command) == wanted


def test_the_ramp_of_wheels_that_slip_goes_beyond_its_target_and_there_the_next_one_begins():
    rig = Rig(Slipping(0.0, 0.0))

    def asked(updates, *command):
        rig.after(updates, *command)
        return pytest.approx(rig.robot.asked)

    assert (asked(10, 0.1, 0.0), asked(2), asked(3)) == (0.1, 0.12, 0.1)
    assert asked(1, 0.0, 0.0) == 0.11


def test_braking_is_no_faster_than_driving_off():
    rig = Rig()
    assert rig.after(200, 1.0, 0.0) == (1.0, 1.0)
    assert rig.after(10, -1.0, 0.0) == (0.89, 0.89)


def test_reset_forgets_the_command_and_the_ramp_after_it_begins_at_zero():
    rig = Rig()
    rig.after(20, 10.0, 0.0)
    rig.drive.reset()
    assert rig.after(3) == (0.0, 0.0)
    assert rig.after(1, 1.0, 0.0) == (0.01, 0.01)


# as floats, 0.07 and 0.14 are slightly larger than 7 * 0.01 and 14 * 0.01
@pytest.mark.parametrize('timeout_s, factor, updates', [
    (0.05, 1.0, 5), (0.07, 1.0, 7), (0.14, 1.0, 14), (0.5, 1.0, 50), (0.054, 1.0, 6),
    (0.001, 1.0, 1), (0.05, 4.0, 20)])
def test_a_command_ends_after_the_timeout(timeout_s, factor, updates):
    rig = Rig(cmd_vel_timeout=timeout_s, **AT_ONCE)
    rig.drive.scale_timeout(2.0)
    rig.drive.scale_timeout(factor)         # not twice this
    assert rig.after(updates, 0.2, 0.0) == (0.2, 0.2) and not rig.drive.timed_out
    for _ in range(3):
        assert rig.after(1) == (0.0, 0.0) and rig.drive.timed_out
    assert rig.after(1, 0.1, 0.0) == (0.1, 0.1) and not rig.drive.timed_out


def test_new_command_restarts_the_timeout():
    rig = Rig(cmd_vel_timeout=0.05, **AT_ONCE)
    for _ in range(4):
        assert rig.after(4, 0.2, 0.0) == (0.2, 0.2)
    assert rig.after(1) == (0.2, 0.2)
    assert rig.after(1) == (0.0, 0.0)


def test_a_timeout_is_reported_if_it_stops_the_robot_until_a_reset():
    rig = Rig(cmd_vel_timeout=0.05, **AT_ONCE)
    rig.after(15, 0.0, 0.0)
    assert not rig.drive.timed_out
    rig.after(6, 0.2, 0.0)
    assert rig.drive.timed_out
    rig.drive.reset()
    assert not rig.drive.timed_out


def test_timeout_of_zero_means_no_timeout():
    rig = Rig(**AT_ONCE)
    rig.drive.scale_timeout(100.0)
    assert rig.after(10000, 0.2, 0.0) == (0.2, 0.2)


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


def test_motors_are_set_when_the_speed_changes_or_something_has_stopped_them():
    rig = Rig(**AT_ONCE)
    rig.after(2, 0.2, 0.0)
    rig.robot.velocities = 9.0, 9.0
    rig.after(2)
    assert rig.robot.velocities == (9.0, 9.0)
    rig.drive.notify_stopped()
    assert rig.after(1) == (0.2, 0.2)
