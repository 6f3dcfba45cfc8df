"""The counters of the simulator, and their report."""
from types import SimpleNamespace
from unittest import mock

import pytest
import rospy
from diagnostic_msgs.msg import DiagnosticStatus

from img_recog.nodes.gazebo import gazebo_node
from img_recog.nodes.gazebo.gazebo_node import SimulatedClock
from img_recog.nodes.gazebo.command_counts import CommandCounts
from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.time_gate import Mode, TimeGate
from img_recog.simulation.pacing import Pace
from img_recog_helpers.statuses import values

OK, WARN = DiagnosticStatus.OK, DiagnosticStatus.WARN


@pytest.fixture
def make(monkeypatch):
    """A function that makes a SimulatedClock without a master."""
    for module, name in ((gazebo_node, 'DirectPublisher'), (rospy, 'Publisher'),
                         (gazebo_node, 'master_calls')):
        monkeypatch.setattr(module, name, mock.MagicMock())

    def running(measured, wanted=1.0, mode=Mode.RUNNING):
        pace = Pace(wanted)
        pace.measured = measured
        return SimulatedClock(SimpleNamespace(time_s=12.345), pace, TimeGate(mode, lambda: None))
    return running


@pytest.mark.parametrize('factors, level, message', [
    ((0.99,), OK, 'real time factor 0.99'), ((0.81,), OK, 'real time factor 0.81'),
    ((0.79,), WARN, 'too slow: real time factor 0.79 instead of 1; '
     'use a smaller real_time_factor, or close windows'),
    ((0.0,), OK, 'real time factor 0.00'),            # not measured yet
    ((25.0, 0.0), OK, 'real time factor 25.00'), ((0.0, 1.0, Mode.PAUSED), OK, 'paused')])
def test_the_level_and_what_to_do(status, make, factors, level, message):
    make(*factors).report(status)
    assert (status.level, status.message) == (level, message)


def test_values_of_the_simulation(status, make):
    clock, calls = make(0.99), ServiceCalls()
    clock.periods.add(0.002)
    calls.late.add()
    clock.report(status)
    calls.report(status)
    assert values(status) == {
        'simulated time (s)': '12.35', 'real time factor': '0.99', 'wanted real time factor': '1',
        'clock period, mean (ms)': '2.00', 'clock period, max (ms)': '2.00',
        'waiting service calls': '0', 'service calls that timed out': '1'}


def test_values_of_a_robot(status, clock):
    counts = CommandCounts(clock)
    counts.report(status, 0.0, False)
    assert status.level == OK
    assert values(status)['age of the last command (s)'] == 'none'
    for is_replacing in (False, True):
        counts.count_received(is_replacing)
    counts.refused.add('linear.x is nan')
    counts.readings.add()
    clock.advance(2.0)
    status.values = []
    counts.report(status, 0.5, False)
    assert values(status) == {
        'commands': '2', 'commands (Hz)': '1.00', 'commands replaced by newer ones': '1',
        'age of the last command (s)': '2.0', 'watchdog': 'stops the robot after 0.5 s',
        'commands refused': '1', 'last reason': 'linear.x is nan', 'sensor messages': '1',
        'sensor messages (Hz)': '0.50'}
    assert (status.level, status.message) == (
        WARN, 'commands refused: 1, the last: linear.x is nan')


@pytest.mark.parametrize('timeout_s, timed_out, level, watchdog', [
    (0.0, False, OK, 'off'), (0.5, False, OK, 'stops the robot after 0.5 s'),
    (0.5, True, WARN, 'stopped the robot after 0.5 s')])
def test_the_watchdog(status, timeout_s, timed_out, level, watchdog):
    CommandCounts().report(status, timeout_s, timed_out)
    assert (status.level, values(status)['watchdog']) == (level, watchdog)
    assert ('no command for 0.5 s' in status.message) == timed_out
