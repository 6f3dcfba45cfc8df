"""Odometry from the world and from the wheels, against the true motion of the burger."""
import math

import numpy as np
import pytest

from img_recog.simulation.physics.drive import DifferentialDrive
from img_recog.simulation.sensors.odometry import EncoderOdometry, OdometrySettings
from img_recog.simulation.sensors.sensor import Mount
from img_recog_helpers.refusals import refusal
from img_recog_helpers.robots import assemble, burgers_drive

ENCODER = OdometrySettings(odometry_source='encoder')


def last_odometry(sim, steps):
    return [each.value for each in sim.advance(steps) if each.sensor == 'odometry'][-1]


def since(start, motion):
    """Return x, y, yaw of a true motion as seen from the frame of a start."""
    x, y = motion.position[:2] - start.position[:2]
    yaw = start.yaw
    return (x * math.cos(yaw) + y * math.sin(yaw), y * math.cos(yaw) - x * math.sin(yaw),
            math.remainder(motion.yaw - yaw, 2 * math.pi))


def planar(motion):
    return (*motion.position[:2], motion.yaw)


def test_world_is_the_true_pose_of_the_root_link_by_default():
    sim = assemble(x=3.0, y=-2.0, yaw=0.5)
    sim.robots[0].command(0.2, 0.5)
    odometry, true = last_odometry(sim, 990), sim.robots[0].body.motion('base_footprint')
    for got, wanted in zip(odometry, true):
        assert got == pytest.approx(wanted, abs=1e-12)
    assert odometry.position[0] > 3.05


def test_world_is_the_true_pose_of_base_frame():
    settings = OdometrySettings(base_frame='base_scan')
    sim = assemble(x=3.0, y=-2.0, yaw=math.pi / 2, odometry=settings)
    # the scanner sits 0.032 m behind the root link's origin and 0.182 m above
    position = last_odometry(sim, 33).position
    assert position == pytest.approx([3.0, -2.032, 0.182], abs=0.002)
    sim.robots[0].command(0.0, 1.0)
    odometry = last_odometry(sim, 1980)
    assert odometry.linear[1] == pytest.approx(-0.032, abs=0.003)   # it is swung to its right
    assert odometry.angular[2] == pytest.approx(1.0, rel=0.02)


def test_a_base_frame_that_is_no_link_is_a_name_for_the_root_link():
    settings = OdometrySettings(base_frame='robot1/base_link')
    sim = assemble(x=3.0, y=-2.0, odometry=settings)
    assert last_odometry(sim, 33).position == pytest.approx([3.0, -2.0, 0.0], abs=0.002)
    assert sim.robots[0].odometry.base_frame == 'robot1/base_link'


def test_encoder_starts_at_zero_wherever_it_stands_and_counts_a_straight_way():
    sim = assemble(x=-1.0, y=4.0, yaw=2.5, odometry=ENCODER)
    assert planar(last_odometry(sim, 33)) == pytest.approx([0, 0, 0], abs=1e-3)
    start = sim.robots[0].body.motion()
    sim.robots[0].command(0.2, 0.0)
    odometry = last_odometry(sim, 33 * 95)
    true = since(start, sim.robots[0].body.motion())
    assert true[0] == pytest.approx(0.6, abs=0.03)
    assert planar(odometry) == pytest.approx(true, abs=0.01)
    assert odometry.position[2] == 0.0


@pytest.mark.parametrize('speed, turn', [(0.2, 0.4), (0.2, -0.4), (-0.2, 0.4)])
def test_encoder_follows_an_arc(speed, turn):
    sim = assemble(x=1.0, y=2.0, yaw=-2.0, odometry=ENCODER)
    start = sim.robots[0].body.motion()
    sim.robots[0].command(speed, turn)
    odometry = last_odometry(sim, 33 * 90)          # 1.2 rad, of a radius of 0.5 m
    true = since(start, sim.robots[0].body.motion())
    assert math.copysign(1, true[2]) == math.copysign(1, turn) and abs(true[2]) > 1.0
    assert planar(odometry) == pytest.approx(true, abs=0.03)     # the tyres slip a little
    assert np.linalg.norm(odometry.orientation) == pytest.approx(1.0)
    # of the child frame
    assert odometry.linear == pytest.approx([speed, 0, 0], abs=0.003)
    assert odometry.angular == pytest.approx([0, 0, turn], abs=0.01)
    assert odometry.linear[0] == pytest.approx(
        sim.robots[0].body.motion().linear[0], rel=0.03)


class Wheels:
    """A robot of which there is only how far its wheels have turned, in rad."""

    def __init__(self, left, right, settings):
        self.turned, self.settings = [left, right], settings

    def wheel_positions(self):
        return tuple(self.turned)

    def roll(self, distance, turn):
        """Turn the wheels as if the robot drove on an arc: m, rad."""
        for wheel, side in enumerate((-1, 1)):
            rim = distance + side * turn * self.settings.wheel_separation / 2
            self.turned[wheel] += rim / (self.settings.wheel_diameter / 2)


@pytest.mark.parametrize('radius', [0.5, -0.5])
def test_encoder_counts_a_circle_exactly_where_no_wheel_slips(radius):
    settings = burgers_drive(wheel_separation=0.2, wheel_diameter=0.1)
    wheels = Wheels(7.0, -3.0, settings)
    odometry = EncoderOdometry(Mount(wheels, None, None, DifferentialDrive(settings)),
                               OdometrySettings(odometry_period_s=0.05))
    places = []
    for _ in range(400):
        turn = math.copysign(2 * math.pi / 400, radius)
        wheels.roll(0.5 * 2 * math.pi / 400, turn)
        places.append(odometry.read())
    assert planar(places[99]) == pytest.approx((0.5, radius, turn * 100), abs=1e-4)
    assert planar(places[199])[:2] == pytest.approx((0.0, 2 * radius), abs=1e-4)
    assert planar(places[399]) == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)
    assert places[399].linear == pytest.approx([0.5 * abs(turn) / 0.05, 0, 0])
    assert places[399].angular == pytest.approx([0, 0, turn / 0.05])


def test_encoder_misses_that_the_wheels_slip():
    # a robot against a wall: the wheels turn on, and the true pose does not
    sim = assemble('turtlebot3_world', x=2.4, y=-0.5, odometry=ENCODER)
    start = sim.robots[0].body.motion()
    sim.robots[0].command(0.22, 0.0)
    odometry = last_odometry(sim, 33 * 100)
    assert odometry.position[0] > since(start, sim.robots[0].body.motion())[0] + 0.3


@pytest.mark.parametrize('reset', ['reset_world', 'reset_simulation'])
def test_encoder_is_at_zero_after_a_reset(reset):
    sim = assemble(x=1.0, yaw=1.0, odometry=ENCODER)
    sim.robots[0].command(0.2, 0.5)
    assert last_odometry(sim, 990).position[0] > 0.05
    getattr(sim, reset)()
    odometry = last_odometry(sim, 33)
    assert planar(odometry) == pytest.approx((0, 0, 0), abs=1e-3)
    assert odometry.linear == pytest.approx([0, 0, 0], abs=0.02)
    assert odometry.angular == pytest.approx([0, 0, 0], abs=0.02)


@pytest.mark.parametrize('source', ['wheels', 'World', ''])
def test_refuses_a_source_it_does_not_know(source):
    line = refusal(OdometrySettings, odometry_source=source)
    assert line.startswith('odometry_source: got {!r}'.format(source))
    assert 'encoder' in line and 'world' in line
