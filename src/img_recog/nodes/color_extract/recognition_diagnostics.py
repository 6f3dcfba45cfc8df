"""The state of the recognition, as in /diagnostics."""
import time
from typing import Callable, Tuple

from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper

from img_recog.ros.diagnostics import (MIN_SHARE, Durations, EventCounter, Refusals, add_counter,
                                       add_durations, add_refusals)

_STALE_S = 2.0          # without an image: longer is a warning
_MAX_LATENCY_S = 60.0   # a larger one is an image with old stamps, as of a bag


class RecognitionDiagnostics:
    """Counters of the node, and their report.

    topic: of the images.
    received: images that arrived; replaced: those of them that a newer one replaced before they
    were processed; refused: those that could not be used; processed: the others.
    commands: published on cmd_vel.
    processing: of an image, from taking it to the last result; latency: from the stamp of an
    image to its commands, in ROS time.
    """

    def __init__(self, topic: str, now: Callable[[], float] = time.monotonic):
        """Start to count.

        topic: of the images.
        """
        self.topic, self._now = topic, now
        self.received, self.replaced = EventCounter(now), EventCounter(now)
        self.processed, self.commands = EventCounter(now), EventCounter(now)
        self.refused = Refusals()
        self.processing, self.latency = Durations(), Durations()
        self._reported, self._last_s = 0, now()

    def count_latency(self, now_s: float, stamp_s: float) -> None:
        """Count the time from the stamp of an image to now, if both are of the same clock."""
        if stamp_s > 0 and 0.0 <= now_s - stamp_s <= _MAX_LATENCY_S:
            self.latency.add(now_s - stamp_s)

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in the status; to be called once in each period."""
        received = self.received.total
        if received != self._reported:
            self._reported, self._last_s = received, self._now()
        received_hz = add_counter(status, 'images received', self.received)
        status.add('images replaced by newer ones', str(self.replaced.total))
        processed_hz = add_counter(status, 'images processed', self.processed)
        add_counter(status, 'commands', self.commands)
        add_durations(status, 'processing', self.processing)
        add_durations(status, 'stamp to commands', self.latency)
        replaced_hz = self.replaced.rate_hz()
        status.summary(*self._summary(received_hz, replaced_hz, processed_hz))
        if add_refusals(status, 'images', self.refused) and processed_hz == 0:
            status.mergeSummary(DiagnosticStatus.ERROR, 'no image can be used: check the camera')

    def _summary(self, received_hz: float, replaced_hz: float, processed_hz: float
                 ) -> Tuple[int, str]:
        silent_s = self._now() - self._last_s
        if silent_s > _STALE_S:
            return DiagnosticStatus.WARN, 'no images on {} {}: start a camera'.format(
                self.topic, 'for {:.0f} s'.format(silent_s) if self._reported else 'yet')
        if replaced_hz > (1 - MIN_SHARE) * received_hz:
            return DiagnosticStatus.WARN, ('too slow: {:.1f} of {:.1f} images a second are '
                                           'processed; use a smaller image or rate'.format(
                                               processed_hz, received_hz))
        return DiagnosticStatus.OK, '{:.1f} Hz'.format(processed_hz)
