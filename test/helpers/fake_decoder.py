"""A fake of the decoder of a video or stream."""
import numpy as np

from img_recog.camera.source import FrameSkipped

IMAGE = np.zeros((48, 64, 3), np.uint8)


class FakeDecoder:
    """Performs steps: True is a frame, False the end; numbers are seconds before a frame.

    A negative number is a damaged frame. An array is a frame, too.
    """

    def __init__(self, clock, steps, rate_hz=0.0, frame_count=0, width=0, height=0, times_s=(),
                 is_segmented=False):
        self._clock, self._steps, self._times_s = clock, list(steps), iter(times_s)
        self.rate_hz, self.frame_count, self.width, self.height = (
            rate_hz, frame_count, width, height)
        self.is_segmented = is_segmented
        self.codec, self.time_s, self.released = 'h264', None, False

    def read(self):
        step = self._steps.pop(0)
        self.time_s = next(self._times_s, None)
        if isinstance(step, np.ndarray):
            return step
        if isinstance(step, bool):
            return IMAGE if step else None
        self._clock.advance(abs(step))
        if step < 0:
            raise FrameSkipped('rtsp://camera/live gave an empty or damaged frame')
        return IMAGE

    def release(self):
        self.released = True
