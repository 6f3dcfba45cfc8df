"""The ramp of the wheel speeds, without physics: wheels that turn as they are told."""
import pytest

from img_recog.simulation.differential_drive import DifferentialDrive
from img_recog.simulation.settings import DriveSettings

RADIUS = 0.033


def follow(drive, updates, start=(0.0, 0.0)):
    """Return the rim speeds in m/s after each of so many updates."""
    velocities, history = start, []
    for _ in range(updates):
        velocities = drive.update(velocities)
        history.append(tuple(velocity * RADIUS for velocity in velocities))
    return history


def test_ramp_is_one_metre_a_second_squared():
    drive = DifferentialDrive(DriveSettings())
    drive.command(10.0, 0.0)
    speeds = follow(drive, 50)
    assert speeds[0] == pytest.approx((0.01, 0.01))
    assert speeds[-1] == pytest.approx((0.5, 0.5))      # after half a second


def test_ends_at_the_target():
    drive = DifferentialDrive(DriveSettings())
    drive.command(0.105, 0.0)
    assert follow(drive, 20)[-1] == pytest.approx((0.105, 0.105))


def test_turning_left_drives_the_right_wheel_forward():
    drive = DifferentialDrive(DriveSettings())
    drive.command(0.0, 1.0)
    assert follow(drive, 100)[-1] == pytest.approx((-0.08, 0.08))


def test_one_wheel_near_its_target_sets_both():
    drive = DifferentialDrive(DriveSettings())
    drive.command(0.5, 0.5 / 0.08)      # left 0, right 1 m/s: left is there already
    assert follow(drive, 1)[-1] == pytest.approx((0.0, 1.0))


def test_braking_is_no_faster_than_driving_off():
    drive = DifferentialDrive(DriveSettings())
    drive.command(1.0, 0.0)
    follow(drive, 200)
    drive.command(-1.0, 0.0)
    speeds = follow(drive, 10, start=(1 / RADIUS, 1 / RADIUS))
    assert speeds[-1] == pytest.approx((0.9, 0.9))


def test_no_acceleration_limit_sets_at_once():
    drive = DifferentialDrive(DriveSettings(wheel_acceleration=0.0))
    drive.command(10.0, 0.0)
    assert follow(drive, 1)[-1] == pytest.approx((10.0, 10.0))


def test_reset_forgets_the_command():
    drive = DifferentialDrive(DriveSettings())
    drive.command(10.0, 0.0)
    follow(drive, 20)
    drive.reset()
    assert follow(drive, 3)[-1] == (0.0, 0.0)
