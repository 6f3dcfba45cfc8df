"""Counters of the commands of a robot, for /diagnostics."""
import time
from typing import Callable, Optional

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.ros.diagnostics import EventCounter, Refusals, add_counter, add_refusals


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
