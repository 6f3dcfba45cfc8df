"""The interface of all frame sources, and what they have in common."""
import abc
import re
from typing import Optional

import cv2
import numpy as np

from img_recog.errors import UserError
from img_recog.formats import still_images
from img_recog.settings import ParameterError

# In a URL. As in ffmpeg, the authority ends at the first of /?#, and the user at the last @ in it.
# If a password contains one of these, no port follows the colon: then the last @ of all counts.
_USER = re.compile(r'(?<=://)(?:[^/?#]*@|[^/?#]*:(?!\d*(?:[/?#]|$)).*@)')
_QUERY = re.compile(r'(?<=[?#]).*')


class SourceError(UserError):
    """A frame source cannot be opened or gives no more frames."""


class RefusedSource(SourceError, ParameterError):
    """What the user gave is not a source, and will not become one."""


class SourceTooLarge(SourceError):
    """A frame source has more pixels than are allowed."""


class SourceEnded(Exception):
    """A video or folder has no more frames; the text is one line for the log."""


class FrameSkipped(Exception):
    """One frame could not be used, the next one may be; the text is one line for the log."""


class FrameSource(abc.ABC):
    """A stream of frames of one encoding.

    description: the origin of the frames and their format, one line for the log.
    name: the origin of the frames as the user named it.
    width, height: size of the last frame, before it of the first, in pixels. It changes if that of
    a video or stream does.
    encoding: encoding of all frames, `rgb8` or `mono8` (sensor_msgs/image_encodings.h).
    differs: whether the format or size is not the one that was requested.
    rate_hz: the rate at which to play the frames, or None when `read` waits for the device.
    expected_hz: the rate at which frames are expected to arrive, None when it is not known.
    max_hz: the rate above which frames are dropped, None for no limit.
    reconnects: whether to reopen it after `read` has failed.
    loops: whether to reopen it after it has ended, and to go on as if it had not.
    stall_timeout_s: a `read` that takes longer is a stall; None for no timeout.
    age_s: time from the capture of the last frame to the return of `read`.
    time_s: when the last frame is due, counted from the first one; None: at `rate_hz`.
    step_s: time between the last frame and the next one; None: the period of `rate_hz`.
    expected_frames: how many there are, 0 if that is not known.
    damaged: how many frames of a video were skipped before the last one, or the end.
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
    loops: bool = False
    stall_timeout_s: Optional[float] = None
    age_s: float = 0.0
    time_s: Optional[float] = None
    step_s: Optional[float] = None
    expected_frames: int = 0
    damaged: int = 0

    @abc.abstractmethod
    def read(self) -> np.ndarray:
        """Return the next frame, uint8 of shape (height, width, 3), or (height, width) if mono8.

        The caller must not modify the array, which may be returned again. Raises SourceEnded
        when all frames have been read, FrameSkipped when one cannot be used, and SourceError when
        there are no more frames for another reason.
        """

    def close(self) -> None:
        """Release the resources of the source; no effect when it is closed already."""


def convert(image: np.ndarray, encoding: str) -> np.ndarray:
    """Return an image from OpenCV, bgr8 or mono8, in the encoding to publish.

    encoding: `rgb8` or `mono8`.

    >>> convert(np.array([[[255, 128, 0]]], np.uint8), 'rgb8').tolist()
    [[[0, 128, 255]]]
    """
    if encoding == 'mono8':
        return image if image.ndim == 2 else cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    return cv2.cvtColor(image, cv2.COLOR_GRAY2RGB if image.ndim == 2 else cv2.COLOR_BGR2RGB)


def fourcc(capture: cv2.VideoCapture) -> str:
    """Return the four letters of the codec or pixel format that OpenCV reads, without spaces."""
    code = int(capture.get(cv2.CAP_PROP_FOURCC))
    return ''.join(chr(code >> shift & 0x7f) for shift in (0, 8, 16, 24)).strip(' \0')


def redacted(name: str) -> str:
    """Return a `video_device` for the log: a URL without user and query, which may be secret.

    >>> redacted('rtsp://me:secret@camera/live?key=secret')
    'rtsp://camera/live?...'
    """
    return _QUERY.sub('...', _USER.sub('', name)) if '://' in name else name


def check_size(action: str, width: float, height: float, max_pixels: int) -> None:
    """Raise SourceTooLarge, which says `action`, for frames of more than `max_pixels` pixels."""
    try:
        still_images.check_size(width, height, max_pixels)
    except still_images.ImageTooLarge as error:
        raise SourceTooLarge('{}: {}'.format(action, error.problem), error.advice)
