"""What every frame source offers to those who capture from it."""
import abc
from typing import Optional

import numpy as np

from img_recog.errors import UserError


class SourceError(UserError):
    """A frame source cannot be opened or gives no more frames."""


class SourceEnded(Exception):
    """A video or folder is over; the text says so in one line."""


class FrameSkipped(Exception):
    """One frame could not be used, the next may be; the text says why in one line."""


class FrameSource(abc.ABC):
    """A stream of frames of one size and encoding.

    description: one line for the log, what the frames come from and in which format.
    name: what the frames come from, as the user named it.
    width, height: of every frame, in pixels.
    encoding: of every frame, `rgb8` or `mono8` (sensor_msgs/image_encodings.h).
    differs: whether the format or size is another than was asked for.
    rate_hz: the rate to play the frames at, or None where `read` itself waits for the device.
    expected_hz: the rate at which frames are expected to come, None where nobody knows.
    max_hz: the rate above which frames are left out, None for none.
    reconnects: whether it may come back after `read` has failed, and is worth waiting for.
    stall_timeout_s: a `read` that takes longer means that something is wrong; None: never.
    age_s: from the capture of the frame that was read last to the return of `read`.
    """

    description: str
    name: str
    width: int
    height: int
    encoding: str = 'rgb8'
    differs: bool = False
    rate_hz: Optional[float] = None
    expected_hz: Optional[float] = None
    max_hz: Optional[float] = None
    reconnects: bool = False
    stall_timeout_s: Optional[float] = None
    age_s: float = 0.0

    @abc.abstractmethod
    def read(self) -> np.ndarray:
        """Return the next frame, uint8 of shape (height, width, 3), or (height, width) if mono8.

        The array may be given out again and must not be changed. Raises SourceEnded when all
        frames have been read, FrameSkipped when one cannot be used, and SourceError when there
        are no more for another reason.
        """

    def close(self) -> None:
        """Give back what the source holds; harmless when repeated."""
