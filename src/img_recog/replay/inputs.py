"""The input of a replay: its file type, the frames of a video, and reading frames ahead."""
import shlex
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING, Any, Iterable, Iterator, List, TypeVar

import genpy
from std_msgs.msg import Header

from img_recog.camera.selection import open_file
from img_recog.camera.settings import CameraSettings
from img_recog.camera.source import SourceEnded, SourceError, SourceTooLarge
from img_recog.errors import UserError
from img_recog.replay.chain import SECOND_NS, Frame
from img_recog.still_images import DEFAULT_MAX_PIXELS

if TYPE_CHECKING:
    from img_recog.replay.camera_infos import CameraInfos

WANTED = 'give a video that FFmpeg plays, or a bag with images'
DEFAULT_TOPICS = ('/usb_cam/image_raw', '/usb_cam/image_raw/compressed')
_MAGIC = b'#ROSBAG'
_END: Any = object()     # after the last item
Item = TypeVar('Item')


def is_bag(path: str) -> bool:
    """Return whether a file is a bag, by its first bytes or by its name."""
    with open(path, 'rb') as file:
        return file.read(len(_MAGIC)) == _MAGIC or path.endswith('.bag')


class VideoFrames:
    """The frames of a video, stamped with their times in it, from 0.

    expected: the expected number of frames, 0 if unknown; period_ns: how long the last frame is
    shown, complete after it; warnings: messages for the user, complete after the last frame.
    """

    def __init__(self, path: str, max_pixels: int = DEFAULT_MAX_PIXELS):
        """Open a video; raise UserError if it cannot be played or has more pixels."""
        from img_recog.camera.video_source import VideoSource  # takes time; a bag does not need it
        self._path = path
        self._truncated: List[str] = []
        try:
            source = open_file(path, 1.0, loop=False, warn=self._truncated.append,
                               max_pixels=max_pixels)
        except SourceTooLarge:
            raise
        except SourceError as error:
            # the advice of the camera, to set one of its parameters, does not help here
            raise UserError(error.problem, WANTED)
        if not isinstance(source, VideoSource):
            source.close()
            raise UserError('{} is an image'.format(path), WANTED)
        self._source = source
        self.expected = source.expected_frames
        self.period_ns = round(SECOND_NS / source.rate_hz)
        self.warnings: List[str] = []

    def camera_infos(self) -> 'CameraInfos':
        """Return those of a camera that is not calibrated."""
        # imported here because few need it
        from img_recog.replay.camera_infos import of_calibration
        return of_calibration(None)

    def close(self) -> None:
        """Close the video, whose frames are not needed."""
        self._source.close()

    def __iter__(self) -> Iterator[Frame]:
        """Yield all frames; raise UserError at the end if the video is truncated."""
        number, frame_id = 0, CameraSettings().camera_frame_id
        first = '{0.width}x{0.height}'.format(self._source)
        try:
            while True:
                image = self._source.read()
                size = '{0.width}x{0.height}'.format(self._source)
                if size != first and not self.warnings:
                    self.warnings.append(
                        'the video {} changes its size from {} to {} after {:g} s: all frames are '
                        'used, each with its size'.format(self._path, first, size,
                                                          self._source.time_s))
                stamp_ns = round(self._source.time_s * SECOND_NS)
                self.period_ns = round(self._source.step_s * SECOND_NS)
                header = Header(number, genpy.Time(*divmod(stamp_ns, SECOND_NS)), frame_id)
                yield Frame(number, stamp_ns, header, image, self._source.encoding)
                number += 1
        except SourceEnded:
            pass
        finally:
            self._source.close()
        if self._truncated:
            raise UserError(self._truncated[0], 'get a complete copy, or convert the readable '
                            'part: ffmpeg -i {} readable.mkv'.format(shlex.quote(self._path)))


def prefetch(items: Iterable[Item], depth: int) -> Iterator[Item]:
    """Yield the same items in the same order, of which a thread makes up to `depth` ahead.

    An exception raised by `items` is raised at the same place.
    """
    advance = partial(next, iter(items), _END)
    with ThreadPoolExecutor(1) as pool:
        pending = deque(pool.submit(advance) for _ in range(depth))
        while True:
            item = pending.popleft().result()
            if item is _END:
                return
            pending.append(pool.submit(advance))
            yield item
