"""What every frame source offers to the node."""
import abc
from typing import Optional

import numpy as np

from img_recog.errors import UserError


class SourceError(UserError):
    """A frame source cannot be opened or gives no more frames."""


class FrameSource(abc.ABC):
    """A stream of frames of one size and encoding.

    description: one line for the log, what the frames come from and in which format.
    width, height: of every frame, in pixels.
    encoding: of every frame, `rgb8` or `mono8` (sensor_msgs/image_encodings.h).
    rate_hz: the rate to play the frames at, or None where `read` itself waits for the device.
    """

    description: str
    width: int
    height: int
    encoding: str = 'rgb8'
    rate_hz: Optional[float] = None

    @abc.abstractmethod
    def read(self) -> np.ndarray:
        """Return the next frame, uint8 of shape (height, width, 3), or (height, width) if mono8.

        The array belongs to the caller. Raises SourceError when there is no next frame.
        """

    def close(self) -> None:
        """Give back what the source holds; harmless when repeated."""
