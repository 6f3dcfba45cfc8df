"""The state of the simulation, as in /diagnostics."""
import time
from typing import Callable, Optional, Tuple

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.nodes.gazebo.physics_services import ServiceCalls
from img_recog.nodes.gazebo.time_gate import TimeGate
from img_recog.ros.diagnostics import (MIN_SHARE, Durations, EventCounter, Refusals, add_counter,
                                       add_durations, add_refusals)
from img_recog.simulation.pacing import Pace


class CommandCounts:
    """Counters of one robot.

    received: commands that arrived and can be used; refused: the others; replaced: those that a
    newer one replaced before the loop used them; readings: published messages of sensors.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now = now
        self.received, self.replaced = EventCounter(now), EventCounter(now)
        self.refused, self.readings = Refusals(), EventCounter(now)
        self._last_s: Optional[float] = None

    def count_received(self, is_replacing: bool) -> None:
        """Count a command that can be used."""
        self._last_s = self._now()
        self.received.add()
        if is_replacing:
            self.replaced.add()

    def age_s(self) -> Optional[float]:
        """Return the wall seconds since the newest command, None before the first."""
        return None if self._last_s is None else self._now() - self._last_s

    def report(self, status: DiagnosticStatusWrapper, timeout_s: float, timed_out: bool) -> None:
        """Add the values to the status; to be called once in each period.

        timeout_s: cmd_vel_timeout, scaled; timed_out: whether it has stopped the robot.
        """
        age_s = self.age_s()
        add_counter(status, 'commands', self.received)
        status.add('commands replaced by newer ones', str(self.replaced.total))
        status.add('age of the last command (s)', 'none' if age_s is None
                   else '{:.1f}'.format(age_s))
        status.add('watchdog', 'off' if not timeout_s else '{} after {:g} s'.format(
            'stopped the robot' if timed_out else 'stops the robot', timeout_s))
        if timed_out:
            status.mergeSummary(DiagnosticStatus.WARN, (
                'no command for {:g} s: the robot is stopped; check color_extract and the '
                'teleop'.format(timeout_s)))
        add_refusals(status, 'commands', self.refused)
        add_counter(status, 'sensor messages', self.readings)


class SimulationDiagnostics:
    """Measures the loop and reports the state of the simulation.

    steps: how long the loop takes for a clock period of simulated time, without waiting.
    """

    def __init__(self, pace: Pace, gate: TimeGate, calls: ServiceCalls):
        self._pace, self._gate, self._calls = pace, gate, calls
        self.steps = Durations()

    def report(self, status: DiagnosticStatusWrapper, time_s: float) -> None:
        """Fill in the status at a simulated time; to be called once in each period."""
        pace = self._pace
        status.summary(*_summary(pace, self._gate.is_paused))
        status.add('simulated time (s)', '{:.2f}'.format(time_s))
        status.add('real time factor', '{:.2f}'.format(pace.measured))
        status.add('wanted real time factor', '{:g}'.format(pace.wanted))
        add_durations(status, 'clock period', self.steps)
        status.add('waiting service calls', str(len(self._calls)))
        status.add('service calls that timed out', str(self._calls.late.total))


def _summary(pace: Pace, is_paused: bool) -> Tuple[int, str]:
    if is_paused:
        return DiagnosticStatus.OK, 'paused'
    if 0 < pace.measured < MIN_SHARE * pace.wanted:
        return DiagnosticStatus.WARN, (
            'too slow: real time factor {:.2f} instead of {:g}; use a smaller real_time_factor, '
            'or close windows'.format(pace.measured, pace.wanted))
    return DiagnosticStatus.OK, 'real time factor {:.2f}'.format(pace.measured)
