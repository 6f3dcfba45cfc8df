"""A base that is moved itself, with a robot that only remembers the velocity in place of one."""
import cmath

import pytest

from img_recog import rotations
from img_recog.simulation.physics.body import FrameState
from img_recog.simulation.physics.drive import PlanarDrive
from img_recog.simulation.physics.robot import Motors
from img_recog.simulation.simulation_settings import DriveSettings

YAW = 0.7


class Base:
    """A robot whose root link is somewhere, turned by YAW, and moves in all directions."""

    root = 'base'

    def __init__(self):
        self.linear = self.angular = None

    def frame_state(self, frame):
        assert frame == 'base'
        return FrameState(((1.0, 2.0, 3.0), rotations.of_yaw(YAW)), (1.5, 1.2, 2.9),
                          (0.1, 0.2, 0.3), (0.4, 0.5, 0.6))

    def set_velocity(self, linear, angular):
        self.linear, self.angular = linear, angular


def updated(drive, updates=1):
    """Return the velocity: forward and left, of an update that begins at YAW; upward; turn."""
    base = Base()
    for _ in range(updates):
        drive.update(base)
    way = complex(*base.linear[:2]) / cmath.rect(1, YAW)
    return way.real, way.imag, base.linear[2], base.angular[2]


def test_moves_as_in_the_middle_of_the_period_and_falls_and_tilts_as_before():
    drive, base = PlanarDrive(DriveSettings(drive_period_s=0.1)), Base()
    drive.command(0.5, 2.0, -0.3)
    drive.update(base)
    wanted = complex(0.5, -0.3) * cmath.rect(1, YAW + 0.1)
    # upward as the root link, which is beside the point whose velocity is known
    assert base.linear == pytest.approx((wanted.real, wanted.imag, 0.3 + 0.4 * 0.8 + 0.5 * 0.5))
    assert base.angular == (0.4, 0.5, 2.0)


def test_stands_without_a_command_and_after_a_reset():
    drive = PlanarDrive(DriveSettings())
    assert updated(drive)[:2] == (0.0, 0.0) and updated(drive)[3] == 0.0
    drive.command(0.5, 0.0)
    assert updated(drive) == pytest.approx((0.5, 0.0, 0.87, 0.0))
    drive.reset()
    assert updated(drive)[:2] == (0.0, 0.0)


def test_counts_where_it_is_and_drives_no_joints():
    drive = PlanarDrive(DriveSettings())
    assert drive.encoders(Base()) == pytest.approx((1.0, 2.0, YAW))
    assert drive.motors == Motors((), 0.0, slides=True)


# the second turn goes over the back
@pytest.mark.parametrize('before, now, turn', [
    (0.5, 2.5, 2.0), (3.0, -2.9, 2 * cmath.pi - 5.9), (-0.5, -2.7, -2.2)])
def test_the_way_between_two_places_is_in_the_mean_direction(before, now, turn):
    forward, left, turned = PlanarDrive(DriveSettings()).travelled(
        (1.0, 2.0, before), (1.3, 1.6, now))
    way = complex(0.3, -0.4) / cmath.rect(1, before + turn / 2)
    assert (forward, left, turned) == pytest.approx((way.real, way.imag, turn))


@pytest.mark.parametrize('command, wanted', [
    ((9.0, 0.0, 0.2), (0.4, 0.2, 0.0)), ((-9.0, 0.0, -0.05), (-0.1, -0.05, 0.0)),
    ((0.3, 0.0, 9.0), (0.3, 0.4, 0.0)), ((0.3, 0.0, -9.0), (0.3, -0.1, 0.0)),
    ((0.0, 9.0, 0.0), (0.0, 0.0, 0.7)), ((0.0, -9.0, 0.0), (0.0, 0.0, -0.2)),
    ((0.0, 0.6, 0.0), (0.0, 0.0, 0.6))])
def test_velocities_have_a_highest_and_a_lowest_value(command, wanted):
    drive = PlanarDrive(DriveSettings(
        max_linear_velocity=0.4, min_linear_velocity=-0.1, max_angular_velocity=0.7,
        min_angular_velocity=-0.2, drive_period_s=1e-9))
    drive.command(*command)
    forward, left, _, turn = updated(drive)
    assert (forward, left, turn) == pytest.approx(wanted)


@pytest.mark.parametrize('limits, command, wanted', [
    ({}, (2.0, 0.0, 2.0), (0.8, 0.8, 0.0)), ({}, (-2.0, 0.0, -2.0), (-0.4, -0.4, 0.0)),
    ({}, (0.3, 0.0, 9.0), (0.3, 0.8, 0.0)), ({}, (0.0, 9.0, 0.0), (0.0, 0.0, 1.2)),
    ({}, (0.0, -9.0, 0.0), (0.0, 0.0, -0.6)),
    ({'min_linear_acceleration': 0.0}, (-2.0, 0.0, 0.3), (-0.8, 0.3, 0.0)),
    ({'min_angular_acceleration': 0.0}, (0.0, -9.0, 0.0), (0.0, 0.0, -1.2)),
    ({'max_linear_acceleration': 0.0}, (9.0, 0.0, -9.0), (9.0, -0.4, 0.0)),
    ({'max_angular_acceleration': 0.0}, (0.0, 9.0, 0.0), (0.0, 0.0, 9.0))])
def test_changes_have_a_highest_and_a_lowest_value(limits, command, wanted):
    drive, base = PlanarDrive(DriveSettings(**{
        'drive_period_s': 0.2, 'max_linear_acceleration': 2.0, 'min_linear_acceleration': -1.0,
        'max_angular_acceleration': 3.0, 'min_angular_acceleration': -1.5, **limits})), Base()
    drive.command(*command)
    drive.update(base)
    drive.update(base)
    # the direction of the second update, which has turned by half of its way
    way = complex(*base.linear[:2]) / cmath.rect(1, YAW + wanted[2] * 0.1)
    assert (way.real, way.imag, base.angular[2]) == pytest.approx(wanted)


@pytest.mark.parametrize('timeout_s', [0.05, 0.5])
def test_its_timeout(timeout_s):
    drive = PlanarDrive(DriveSettings(cmd_vel_timeout=timeout_s, drive_period_s=0.02))
    assert drive.timeout_s == pytest.approx(timeout_s)
    drive.scale_timeout(3.0)
    assert drive.timeout_s == pytest.approx(3 * timeout_s)
