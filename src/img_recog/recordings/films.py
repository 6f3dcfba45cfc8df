"""Films, pictures and folders of pictures as frames."""
import shlex
from typing import TYPE_CHECKING, Iterator, List

import genpy
from std_msgs.msg import Header

from img_recog.camera.image_source import ImageSource
from img_recog.camera.selection import open_file
from img_recog.camera.source import FrameSkipped, SourceEnded, SourceError, SourceTooLarge
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.errors import UserError
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS
from img_recog.recordings.frames import SECOND_NS, WANTED, Frame, Frames

if TYPE_CHECKING:
    from img_recog.recordings.camera_infos import CameraInfos


class FilmFrames(Frames):
    """The frames of a film, a picture or the pictures of a folder, as the camera node shows them.

    They are stamped with their times, from 0: those of a film, or, of pictures, at a rate.
    """

    def __init__(self, path: str, max_pixels: int = DEFAULT_MAX_PIXELS,
                 rate_hz: float = UsbCamSettings.framerate):
        """Open a film or pictures; raise UserError if it is neither or has more pixels."""
        super().__init__(path)
        said: List[str] = []
        try:
            self._source = open_file(path, rate_hz, loop=False, warn=said.append,
                                     max_pixels=max_pixels)
        except SourceTooLarge:
            raise
        except SourceError as error:
            # the advice of the camera, to set one of its parameters, does not help here
            raise UserError(error.problem, WANTED)
        self.note(warnings=tuple(said))
        said.clear()
        self._truncated = said      # what comes later says that it is
        self.expected = self._source.expected_frames
        self._rate_hz = self._source.rate_hz or rate_hz
        self.period_ns = round(SECOND_NS / self._rate_hz)

    def camera_infos(self) -> 'CameraInfos':
        """Return those of a camera that is not calibrated."""
        # imported here because few need it
        from img_recog.recordings.camera_infos import of_calibration
        return of_calibration(None)

    def close(self) -> None:
        """Close the film, whose frames are not needed."""
        self._source.close()

    def read(self) -> Iterator[Frame]:
        """Yield all frames; raise UserError at the end if the film is truncated."""
        source, number, damaged = self._source, 0, 0
        frame_id = UsbCamSettings().camera_frame_id
        first, has_changed = '{0.width}x{0.height}'.format(source), False
        try:
            # a picture is repeated without end
            while not (isinstance(source, ImageSource) and number):
                try:
                    image = source.read()
                except FrameSkipped as error:
                    self.note(skipped=1, first='frame {}: {}'.format(number, error))
                    number += 1
                    continue
                number += source.damaged - damaged
                damaged = source.damaged
                time_s = number / self._rate_hz if source.time_s is None else source.time_s
                size = '{0.width}x{0.height}'.format(source)
                if size != first and not has_changed:
                    has_changed = True
                    self.note(warnings=(
                        'the video {} changes its size from {} to {} after {:g} s: all frames are '
                        'used, each with its size'.format(self.path, first, size, time_s),))
                stamp_ns = round(time_s * SECOND_NS)
                self.period_ns = round((source.step_s or 1.0 / self._rate_hz) * SECOND_NS)
                self.note(used=1)
                header = Header(number, genpy.Time(*divmod(stamp_ns, SECOND_NS)), frame_id)
                yield Frame(number, stamp_ns, header, image, source.encoding)
                number += 1
        except SourceEnded:
            self.note_damaged(source.damaged)
        finally:
            source.close()
        if self._truncated:
            raise UserError(self._truncated[0], 'get a complete copy, or convert the readable '
                            'part: ffmpeg -i {} readable.mkv'.format(shlex.quote(self.path)))
