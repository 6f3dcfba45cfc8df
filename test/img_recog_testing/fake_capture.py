"""A fake of OpenCV's capture of a video or stream."""
import cv2
import numpy as np

IMAGE = np.zeros((48, 64, 3), np.uint8)


class FakeCapture:
    """Performs steps: True is a frame, False a failed read; numbers are seconds before a read.

    A negative number is a read that fails. properties: by their OpenCV names without CAP_PROP_.
    """

    def __init__(self, clock, steps, **properties):
        self._clock, self._steps, self.released = clock, list(steps), False
        self._properties = {getattr(cv2, 'CAP_PROP_' + name): value
                            for name, value in properties.items()}

    def isOpened(self):
        return True

    def get(self, number):
        return self._properties.get(number, 0.0)

    def set(self, number, value):
        return False

    def read(self):
        step = self._steps.pop(0)
        if not isinstance(step, bool):
            self._clock.advance(abs(step))
            step = step > 0
        return (True, IMAGE) if step else (False, None)

    def release(self):
        self.released = True
