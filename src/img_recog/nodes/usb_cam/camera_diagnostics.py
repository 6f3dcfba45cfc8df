"""The state of the camera, as in /diagnostics."""
import time
from typing import Callable, Optional, Tuple

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.camera.source import FrameSource
from img_recog.ros.diagnostics import (MIN_SHARE, WINDOW_S, Durations, EventCounter, Refusals,
                                       add_durations)

_MIN_MEASURED_S = 0.5
# a source that the node reads at a rate; a device gives frames by itself
_LATE = 'the frames are late; a smaller image, a lower rate or fewer subscribers may help'
_DARK = 'more light, a smaller image or fewer subscribers may help'


class CameraDiagnostics:
    """Counts frames, and reports the counts and the rate.

    frames: that were published. skipped: those that could not be used. dropped: those that were
    dropped to keep the rate. late: periods by which frames came later than the source says.
    ages: of the frames when they are captured, where the source knows it.
    publishing: how long it takes to publish a frame.
    """

    def __init__(self, device: str, now: Callable[[], float] = time.monotonic):
        self._device = device
        # what to do without frames, and after a loss
        self._advice = (('check its server and the network',) * 2 if '://' in device else
                        ('check the camera and its cable', 'connect the camera again'))
        self._source: Optional[FrameSource] = None
        self.frames, self.dropped, self.skipped = EventCounter(now), EventCounter(now), Refusals()
        self.late = EventCounter(now)
        self.ages, self.publishing = Durations(), Durations()
        self._lost: Optional[str] = None
        self._losses, self._active = 0, False

    def opened(self, source: FrameSource) -> None:
        """Store the source that was opened, and start to measure its rate."""
        self._source = source
        self.frames.restart()

    def lost(self, reason: str) -> None:
        """Report the loss of the device as an error from now on."""
        self._lost, self._losses = reason, self._losses + 1

    def reconnected(self) -> None:
        """Report the device as present again."""
        self._lost = None

    def set_active(self, active: bool) -> None:
        """Store whether the camera is capturing, not suspended; to be called again and again."""
        if active != self._active:
            self._active = active
            self.frames.restart()

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in the status; to be called once in each period."""
        source, rate_hz = self._source, self._rate_hz()
        expected_hz = source.expected_hz if source else None
        if source is not None and source.max_hz and expected_hz:
            expected_hz = min(expected_hz, source.max_hz)
        status.summary(*self._summary(rate_hz, expected_hz))
        status.add('device', self._device)
        status.add('format', source.description if source else 'not open')
        status.add('frame rate (Hz)', 'unknown' if rate_hz is None else '{:.2f}'.format(rate_hz))
        status.add('expected rate (Hz)', '{:.2f}'.format(expected_hz) if expected_hz
                   else 'unknown')
        for name, count in (('frames', self.frames.total), ('failed reads', self.skipped.total),
                            ('frames dropped', self.dropped.total),
                            ('periods late', self.late.total),
                            ('losses of the device', self._losses)):
            status.add(name, str(count))
        status.add('last failed read', self.skipped.last_reason)
        add_durations(status, 'age of a frame', self.ages)
        add_durations(status, 'publishing a frame', self.publishing)
        if self.skipped.take_recent():
            status.mergeSummary(DiagnosticStatus.WARN, 'failed read: ' + self.skipped.last_reason)

    def _summary(self, rate_hz: Optional[float],
                 expected_hz: Optional[float]) -> Tuple[int, str]:
        if not self._active:
            return DiagnosticStatus.OK, 'suspended'
        lost = self._lost       # another thread may change it
        if lost is not None:
            return DiagnosticStatus.ERROR, '{}; {}'.format(lost, self._advice[1])
        if rate_hz is None:
            return DiagnosticStatus.OK, 'starting' if self._source else 'waiting for a first frame'
        if rate_hz == 0:
            return DiagnosticStatus.WARN, 'no frames: ' + self._advice[0]
        if expected_hz and rate_hz < MIN_SHARE * expected_hz:
            return DiagnosticStatus.WARN, '{:.1f} Hz instead of {:g} Hz: {}'.format(
                rate_hz, expected_hz, _LATE if self._source and self._source.rate_hz else _DARK)
        return DiagnosticStatus.OK, '{:.1f} Hz'.format(rate_hz)

    def _rate_hz(self) -> Optional[float]:
        """Return the rate, or None when there is not enough data yet."""
        expected_hz = self._source.expected_hz if self._source is not None else None
        three_periods_s = 3.0 / expected_hz if expected_hz else 0.0
        # a slow camera needs a longer window
        rate_hz = self.frames.rate_hz(max(WINDOW_S, three_periods_s))
        is_enough = self.frames.measured_s >= max(_MIN_MEASURED_S, three_periods_s)
        return rate_hz if is_enough and self._source else None
