"""The state of the camera, as in /diagnostics."""
import threading
import time
from typing import Callable, List, Optional, Tuple

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.camera.source import FrameSource
from img_recog.ros.diagnostics import Durations, Refusals, add_durations

_WINDOW_S = 3.0         # in which the rate is measured
_MIN_SHARE = 0.8        # of the expected rate: below is a warning


class CameraDiagnostics:
    """Counts frames, and reports the counts and the rate.

    ages: of the frames when they are captured, where the source knows it.
    publishing: how long it takes to publish a frame.
    """

    def __init__(self, device: str, now: Callable[[], float] = time.monotonic):
        self._device, self._now = device, now
        self._lock = threading.Lock()
        self._source: Optional[FrameSource] = None
        self._frames = self._dropped = self._losses = 0
        self._skipped = Refusals()
        self.ages, self.publishing = Durations(), Durations()
        self._lost: Optional[str] = None
        self._active = False
        # (time, frame count at that time) within the window
        self._samples: List[Tuple[float, int]] = []

    def opened(self, source: FrameSource) -> None:
        """Store the source that was opened, and start to measure its rate."""
        with self._lock:
            self._source = source
            self._samples = [(self._now(), self._frames)]

    def count_frame(self) -> None:
        """Count a frame that was published."""
        with self._lock:
            self._frames += 1

    def count_skipped(self, reason: str) -> None:
        """Count a frame that could not be used."""
        self._skipped.add(reason)

    def count_dropped(self) -> None:
        """Count a frame that was dropped to keep the rate."""
        with self._lock:
            self._dropped += 1

    def lost(self, reason: str) -> None:
        """Report the loss of the device as an error from now on."""
        with self._lock:
            self._lost, self._losses = reason, self._losses + 1

    def reconnected(self) -> None:
        """Report the device as present again."""
        with self._lock:
            self._lost = None

    def set_active(self, active: bool) -> None:
        """Store whether the camera is capturing, not suspended; to be called again and again."""
        with self._lock:
            if active != self._active:
                self._active, self._samples = active, [(self._now(), self._frames)]

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in the status; to be called once in each period."""
        with self._lock:
            source, rate_hz = self._source, self._rate_hz()
            expected_hz = source.expected_hz if source else None
            if source is not None and source.max_hz and expected_hz:
                expected_hz = min(expected_hz, source.max_hz)
            status.summary(*self._summary(rate_hz, expected_hz))
            status.add('device', self._device)
            status.add('format', source.description if source else 'not open')
            status.add('frame rate (Hz)', 'unknown' if rate_hz is None
                       else '{:.2f}'.format(rate_hz))
            status.add('expected rate (Hz)', '{:.2f}'.format(expected_hz) if expected_hz
                       else 'unknown')
            for name, count in (('frames', self._frames), ('failed reads', self._skipped.total),
                                ('frames dropped', self._dropped),
                                ('losses of the device', self._losses)):
                status.add(name, str(count))
        status.add('last failed read', self._skipped.last_reason)
        add_durations(status, 'age of a frame', self.ages)
        add_durations(status, 'publishing a frame', self.publishing)
        if self._skipped.take_recent():
            status.mergeSummary(DiagnosticStatus.WARN, 'failed read: ' + self._skipped.last_reason)

    def _summary(self, rate_hz: Optional[float],
                 expected_hz: Optional[float]) -> Tuple[int, str]:
        if not self._active:
            return DiagnosticStatus.OK, 'suspended'
        if self._lost is not None:
            return DiagnosticStatus.ERROR, '{}; connect the camera again'.format(self._lost)
        if rate_hz is None:
            return DiagnosticStatus.OK, 'starting'
        if rate_hz == 0:
            return DiagnosticStatus.WARN, 'no frames: check the camera and its cable'
        if expected_hz and rate_hz < _MIN_SHARE * expected_hz:
            return DiagnosticStatus.WARN, ('{:.1f} Hz instead of {:g} Hz: more light, a smaller '
                                           'image or fewer subscribers may help'.format(
                                               rate_hz, expected_hz))
        return DiagnosticStatus.OK, '{:.1f} Hz'.format(rate_hz)

    def _rate_hz(self) -> Optional[float]:
        """Return the rate within the window, or None when there is not enough data yet."""
        now_s, three_periods_s = self._now(), 0.0
        if self._source is not None and self._source.expected_hz:
            three_periods_s = 3.0 / self._source.expected_hz
        self._samples.append((now_s, self._frames))
        window_s = max(_WINDOW_S, three_periods_s)      # a slow camera needs a longer window
        while len(self._samples) > 2 and self._samples[1][0] < now_s - window_s:
            self._samples.pop(0)
        begin_s, begin_count = self._samples[0]
        if now_s - begin_s < max(0.5, three_periods_s):
            return None
        return (self._frames - begin_count) / (now_s - begin_s)
