"""What is replayed: which kind of file it is, and the frames of a video."""
from collections import deque
from concurrent.futures import ThreadPoolExecutor
from typing import Iterable, Iterator, TypeVar

import genpy
from std_msgs.msg import Header

from img_recog.camera.selection import open_file
from img_recog.camera.settings import CameraSettings
from img_recog.camera.source import SourceEnded, SourceError
from img_recog.camera.video_source import VideoSource
from img_recog.errors import UserError
from img_recog.replay.chain import SECOND_NS, Frame

WANTED = 'give a video that OpenCV plays, or a bag with images'
DEFAULT_TOPICS = ('/usb_cam/image_raw', '/usb_cam/image_raw/compressed')
_MAGIC = b'#ROSBAG'
_END = object()
Item = TypeVar('Item')


def is_bag(path: str) -> bool:
    """Return whether a file is a bag, by its first bytes or, if it has none of use, its name."""
    with open(path, 'rb') as file:
        return file.read(len(_MAGIC)) == _MAGIC or path.endswith('.bag')


class VideoFrames:
    """Plays a video once: frame k is at k / rate.

    expected: how many frames there may be, 0 where nobody knows; period_ns: between two frames;
    warnings: what to tell the user once all frames have been given out.
    """

    def __init__(self, path: str):
        """Open a video; UserError when it cannot be played."""
        self._path, self._broken = path, []
        try:
            source = open_file(path, 1.0, loop=False, warn=self._broken.append)
        except SourceError as error:
            # the advice of the camera, to set one of its parameters, does not help here
            raise UserError(error.problem, WANTED)
        if not isinstance(source, VideoSource):
            source.close()
            raise UserError('{} is an image; {}'.format(path, WANTED))
        self._source = source
        self.expected = source.expected_frames
        self.period_ns = round(SECOND_NS / source.rate_hz)
        self.warnings = []

    def __iter__(self) -> Iterator[Frame]:
        """Yield all frames; UserError at the end of a video that breaks off."""
        number, frame_id = 0, CameraSettings().camera_frame_id
        try:
            while True:
                image = self._source.read()
                stamp_ns = round(number * SECOND_NS / self._source.rate_hz)
                header = Header(number, genpy.Time(*divmod(stamp_ns, SECOND_NS)), frame_id)
                yield Frame(number, stamp_ns, header, image, self._source.encoding)
                number += 1
        except SourceEnded:
            pass
        finally:
            self._source.close()
        if self._broken:
            raise UserError('{}; get it whole, or make a video of what there is: ffmpeg -i {} '
                            'whole.mkv'.format(self._broken[0], self._path))


def prefetch(items: Iterable[Item], depth: int) -> Iterator[Item]:
    """Yield the same items in the same order, with up to `depth` of them made ahead in a thread.

    An exception that is raised while an item is made is raised in its place.
    """
    iterator = iter(items)
    with ThreadPoolExecutor(1) as pool:
        making = deque(pool.submit(next, iterator, _END)
                       for _ in range(depth))
        while True:
            item = making.popleft().result()
            if item is _END:
                return
            making.append(pool.submit(next, iterator, _END))
            yield item
