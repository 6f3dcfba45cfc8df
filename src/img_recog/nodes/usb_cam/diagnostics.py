"""How the camera does, on /diagnostics, by the distribution's diagnostic_updater."""
import threading
import time
from typing import Callable, Optional

import diagnostic_updater
from diagnostic_msgs.msg import DiagnosticStatus

from img_recog.camera.source import FrameSource

_PERIOD_S = 1.0
_WINDOW_S = 3.0         # over which the rate is measured
_LEAST_SHARE = 0.8      # of the expected rate that is still well


class CameraDiagnostics:
    """Counts what happens to frames, and publishes it once a second of wall time.

    Publishes: /diagnostics (diagnostic_msgs/DiagnosticArray, one status NODE: camera).
    """

    def __init__(self, device: str, now: Callable[[], float] = time.monotonic):
        self._device, self._now = device, now
        self._lock = threading.Lock()
        self._source: Optional[FrameSource] = None
        self._frames = self._skipped = self._dropped = self._losses = 0
        self._lost: Optional[str] = None
        self._active = False
        self._marks = []        # (time, frames until then) of the window
        self._next_s = now()
        self._updater = diagnostic_updater.Updater()
        self._updater.setHardwareID(device)
        self._updater.add('camera', self.report)

    def opened(self, source: FrameSource) -> None:
        """Take note of a source that was opened."""
        with self._lock:
            self._source = source
            self._marks = [(self._now(), self._frames)]

    def count_frame(self) -> None:
        """Take note of a frame that was published."""
        with self._lock:
            self._frames += 1

    def count_skipped(self) -> None:
        """Take note of a frame that could not be used."""
        with self._lock:
            self._skipped += 1

    def count_dropped(self) -> None:
        """Take note of a frame that was left out to keep the rate."""
        with self._lock:
            self._dropped += 1

    def lost(self, reason: str) -> None:
        """Take note of a device that is gone."""
        with self._lock:
            self._lost, self._losses = reason, self._losses + 1

    def reconnected(self) -> None:
        """Take note of a device that is back."""
        with self._lock:
            self._lost = None

    def update(self, active: bool) -> None:
        """Publish when it is time to; to be called several times a second.

        active: whether frames are wanted.
        """
        now_s = self._now()
        if now_s < self._next_s:
            return
        self._next_s = max(self._next_s + _PERIOD_S, now_s)
        with self._lock:
            if active != self._active:
                self._active, self._marks = active, [(now_s, self._frames)]
        self._updater.force_update()

    def report(self, status):
        """Fill in a diagnostic_updater.DiagnosticStatusWrapper and return it."""
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
            for name, count in (('frames', self._frames), ('failed reads', self._skipped),
                                ('frames left out', self._dropped),
                                ('losses of the device', self._losses)):
                status.add(name, str(count))
        return status

    def _summary(self, rate_hz: Optional[float], expected_hz: Optional[float]):
        if not self._active:
            return DiagnosticStatus.OK, 'suspended'
        if self._lost is not None:
            return DiagnosticStatus.ERROR, self._lost
        if rate_hz is None:
            return DiagnosticStatus.OK, 'starting'
        if rate_hz == 0:
            return DiagnosticStatus.WARN, 'no frames'
        if expected_hz and rate_hz < _LEAST_SHARE * expected_hz:
            return DiagnosticStatus.WARN, '{:.1f} Hz in place of {:g} Hz'.format(
                rate_hz, expected_hz)
        return DiagnosticStatus.OK, '{:.1f} Hz'.format(rate_hz)

    def _rate_hz(self) -> Optional[float]:
        """Return the rate over the window, None before there is one."""
        now_s, slow = self._now(), 0.0
        if self._source is not None and self._source.expected_hz:
            slow = 3.0 / self._source.expected_hz       # a slow camera needs a longer window
        self._marks.append((now_s, self._frames))
        while len(self._marks) > 2 and self._marks[1][0] < now_s - max(_WINDOW_S, slow):
            self._marks.pop(0)
        since_s, before = self._marks[0]
        if now_s - since_s < max(0.5, slow):
            return None
        return (self._frames - before) / (now_s - since_s)
