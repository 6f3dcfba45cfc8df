"""Counters of a node, and their report on /diagnostics."""
import threading
import time
from collections import deque
from functools import partial
from typing import Callable, Deque, Optional, Tuple

import diagnostic_updater
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.errors import shortened
from img_recog.ros import lifecycle

_PERIOD_S = 1.0
MIN_SHARE = 0.8             # of a rate that is expected: below is a warning
WINDOW_S = 3.0              # in which rates are measured

Report = Callable[[DiagnosticStatusWrapper], None]


class EventCounter:
    """Counts events. For any thread, but only one calls `rate_hz`.

    measured_s: the time in which the last rate was measured.

    >>> times_s = iter([0.0, 2.0])
    >>> counter = EventCounter(lambda: next(times_s))
    >>> counter.add(3)
    >>> counter.rate_hz()
    1.5
    """

    def __init__(self, now: Callable[[], float] = time.monotonic):
        self._now, self._lock = now, threading.Lock()
        self.total, self.measured_s = 0, 0.0
        # (time, total at that time) within the window
        self._samples: Deque[Tuple[float, int]] = deque()
        self.restart()

    def add(self, count: int = 1) -> None:
        """Count an event, or several."""
        with self._lock:
            self.total += count

    def restart(self) -> None:
        """Measure the rate from now on."""
        with self._lock:
            self._samples = deque([(self._now(), self.total)])

    def rate_hz(self, window_s: float = WINDOW_S) -> float:
        """Return the rate in the last `window_s`; to be called once in each period."""
        with self._lock:
            now_s, total = self._now(), self.total
            while len(self._samples) > 1 and self._samples[1][0] <= now_s - window_s:
                self._samples.popleft()
            begin_s, begin = self._samples[0]
            self._samples.append((now_s, total))
        self.measured_s = now_s - begin_s
        return (total - begin) / self.measured_s if self.measured_s > 0 else 0.0


class Refusals:
    """Counts inputs that were refused, and keeps the newest reason."""

    def __init__(self):
        self._lock = threading.Lock()
        self.total, self.last_reason = 0, ''
        self._reported = 0

    def add(self, reason: object) -> None:
        """Count a refused input."""
        with self._lock:
            self.total += 1
            self.last_reason = shortened(reason)

    def take_recent(self) -> int:
        """Return the number of inputs that were refused since the last call."""
        total = self.total
        recent, self._reported = total - self._reported, total
        return recent


class Durations:
    """Mean and maximum of durations in a period, in seconds."""

    def __init__(self):
        self._lock = threading.Lock()
        self._count, self._sum_s, self._max_s = 0, 0.0, 0.0

    def add(self, seconds: float) -> None:
        """Count a duration."""
        with self._lock:
            self._count += 1
            self._sum_s += seconds
            if seconds > self._max_s:
                self._max_s = seconds

    def take(self) -> Optional[Tuple[float, float]]:
        """Return mean and maximum since the last call; None if there was no duration."""
        with self._lock:
            count, sum_s, max_s = self._count, self._sum_s, self._max_s
            self._count, self._sum_s, self._max_s = 0, 0.0, 0.0
        return (sum_s / count, max_s) if count else None


class NodeDiagnostics:
    """Publishes the status of a node once a second of wall time, in a separate thread.

    Publishes: /diagnostics (diagnostic_msgs/DiagnosticArray, one status NODE: NAME). A loop that
    hangs does not keep it from being published, and is not delayed by it.
    """

    def __init__(self, name: str, hardware_id: str, report: Report):
        """Start to publish.

        report: fills in level, message and values of the status; it is called in the thread.
        """
        self._ended = threading.Event()
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(hardware_id)
        self.add(name, report)
        lifecycle.on_shutdown(self._ended.set)
        threading.Thread(target=self._run, daemon=True).start()

    def add(self, name: str, report: Report) -> None:
        """Publish another status NODE: NAME too."""
        self._updater.add(name, partial(self._fill, report))

    def remove(self, name: str) -> None:
        """Stop to publish a status that was added."""
        self._updater.removeByName(name)

    def _run(self) -> None:
        while not self._ended.wait(_PERIOD_S):
            with lifecycle.until_shutdown():
                self._updater.force_update()

    @staticmethod
    def _fill(report: Report, status: DiagnosticStatusWrapper) -> DiagnosticStatusWrapper:
        status.summary(DiagnosticStatus.OK, '')
        report(status)
        return status


def add_counter(status: DiagnosticStatusWrapper, name: str, counter: EventCounter) -> float:
    """Add total and rate of a counter to a status; return the rate in Hz."""
    rate_hz = counter.rate_hz()
    status.add(name, str(counter.total))
    status.add(name + ' (Hz)', '{:.2f}'.format(rate_hz))
    return rate_hz


def add_refusals(status: DiagnosticStatusWrapper, name: str, refusals: Refusals) -> int:
    """Add refused inputs to a status, with a warning if there are new ones; return their number.

    name: of the inputs, in the plural.
    """
    recent, reason = refusals.take_recent(), refusals.last_reason
    status.add(name + ' refused', str(refusals.total))
    status.add('last reason', reason)
    if recent:
        status.mergeSummary(DiagnosticStatus.WARN,
                            '{} refused: {}, the last: {}'.format(name, recent, reason))
    return recent


def add_durations(status: DiagnosticStatusWrapper, name: str, durations: Durations) -> None:
    """Add mean and maximum of the last period to a status, in milliseconds."""
    taken = durations.take()
    for part, index in (('mean', 0), ('max', 1)):
        status.add('{}, {} (ms)'.format(name, part),
                   '{:.2f}'.format(1000 * taken[index]) if taken else 'none')
