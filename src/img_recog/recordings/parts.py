"""Divides recordings into parts that can be read independently.

The parts of a recording give all its frames, each once, wherever it is divided.
"""
from typing import Iterator, List, Optional, Sequence, Tuple

import genpy
import numpy as np
from av.error import FFmpegError
from std_msgs.msg import Header

from img_recog.camera.decoder import Decoder
from img_recog.camera.frame_pacing import FrameTimes
from img_recog.camera.source import FrameSkipped, check_size
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS
from img_recog.recordings.bags import BagFrames
from img_recog.recordings.films import FilmFrames
from img_recog.recordings.frames import SECOND_NS, Frame, Frames, Part, Remarks
from img_recog.recordings.recording_names import is_bag

FRAMES = 500        # of a part, at least, so that opening the file hardly counts
_COMPLETE = 0.98    # of the frames that a film states; else the whole film tells what is wrong


def divide(path: str, topic: str = '', frames: int = FRAMES,
           max_pixels: int = DEFAULT_MAX_PIXELS) -> List[Part]:
    """Return the parts of a film, a bag or an image.

    topic: of the images in a bag, as for BagFrames. frames: how many a part has, at least.
    A film without key frames or without times is one part.
    Raises UserError if the recording cannot be read.
    """
    if is_bag(path):
        return _divide_bag(path, topic, frames, max_pixels)
    return _divide_film(path, frames, max_pixels)


def read(path: str, part: Part, max_pixels: int = DEFAULT_MAX_PIXELS) -> Frames:
    """Return the frames of a part, as those of the whole recording.

    To be read by `Frames.read`: a part may have no frame that can be used.
    Raises UserError if the recording cannot be read.
    """
    if is_bag(path):
        return BagFrames(path, '', max_pixels, part)
    return _FilmPart(path, part, max_pixels) if part.ticks else FilmFrames(path, max_pixels)


def first(path: str, parts: Sequence[Part], max_pixels: int = DEFAULT_MAX_PIXELS) -> Frame:
    """Return the first usable frame of a recording; raise UserError if there is none."""
    remarks = Remarks()
    for part in parts:
        frames = read(path, part, max_pixels)
        for frame in frames.read():
            return frame
        remarks = remarks.plus(frames.remarks)
    remarks.lines(path)     # raises
    raise AssertionError


def _divide_bag(path: str, topic: str, frames: int, max_pixels: int) -> List[Part]:
    source = BagFrames(path, topic, max_pixels)
    with source.bag:
        times = source.times_ns()
    if not times:
        return [Part(0, 0, source.topic)]
    starts = _starts([number for number in range(len(times))
                      if number == 0 or times[number] > times[number - 1]], len(times), frames)
    return [Part(start, end - start, source.topic, times[start], times[end - 1])
            for start, end in zip(starts, [*starts[1:], len(times)])]


def _starts(possible: List[int], count: int, frames: int) -> List[int]:
    """Return with which frames parts begin, so that no part is shorter than `frames`."""
    starts = [0]
    for number in possible:
        if number - starts[-1] >= frames and count - number >= frames:
            starts.append(number)
    return starts


def _divide_film(path: str, frames: int, max_pixels: int) -> List[Part]:
    whole = FilmFrames(path, max_pixels)       # refuses what cannot be played
    whole.close()
    one = [Part(0, whole.expected)]
    if 0 < whole.expected < 2 * frames:
        return one
    times, keys = _frame_times(path)
    if len(times) < _COMPLETE * whole.expected or len(set(times)) < len(times):
        return one
    times.sort()
    number_of = {time: number for number, time in enumerate(times)}
    starts = _starts(sorted(number_of[key] for key in keys), len(times), frames)
    if len(starts) == 1:
        return one
    stamps_ns = _stamps_ns(path, times)
    return [Part(start, end - start, ticks=tuple(times[start:end]),
                 stamps_ns=tuple(stamps_ns[start:end]))
            for start, end in zip(starts, [*starts[1:], len(times)])]


def _frame_times(path: str) -> Tuple[List[int], List[int]]:
    """Return the times of all frames in ticks, as far as they have one, and of key frames.

    Nothing is decoded.
    """
    with Decoder(path) as decoder:
        try:
            found = [(ticks, is_key) for ticks, is_key in decoder.packet_times()
                     if ticks is not None]
        except FFmpegError:
            return [], []
    return [ticks for ticks, _ in found], [ticks for ticks, is_key in found if is_key]


def _stamps_ns(path: str, times: List[int]) -> List[int]:
    with Decoder(path) as decoder:
        clock = FrameTimes(decoder.rate_hz)
        return [round(clock.next_s(decoder.seconds(ticks)) * SECOND_NS) for ticks in times]


class _FilmPart(Frames):
    """A part of a film."""

    def __init__(self, path: str, part: Part, max_pixels: int):
        super().__init__(path)
        self._part, self._max_pixels = part, max_pixels
        self.expected, self.period_ns = part.frames, 0
        self._damaged = 0       # frames, also of other parts

    def read(self) -> Iterator[Frame]:
        """Yield the frames that are in the part."""
        part, frame_id = self._part, UsbCamSettings().camera_frame_id
        index_of = {ticks: index for index, ticks in enumerate(part.ticks)}
        for ticks, image in self._decoded():
            index = index_of.get(ticks)
            if index is not None:
                check_size('cannot read ' + self.path, image.shape[1], image.shape[0],
                           self._max_pixels)
                self.note(used=1)
                stamp_ns = part.stamps_ns[index]
                header = Header(part.first + index, genpy.Time(*divmod(stamp_ns, SECOND_NS)),
                                frame_id)
                yield Frame(part.first + index, stamp_ns, header, image, 'rgb8')
        self.note_damaged(min(self._damaged, part.frames - self.remarks.used))

    def _decoded(self) -> Iterator[Tuple[int, np.ndarray]]:
        """Yield frames with their times; all of the part, and perhaps some before it."""
        first, last = self._part.ticks[0], self._part.ticks[-1]
        for seeks in (True, False):
            with Decoder(self.path) as decoder:
                if seeks:
                    decoder.seek(first)
                image = self._next_image(decoder)
                if seeks and (decoder.ticks is None or decoder.ticks > first):
                    continue        # seeking is inexact in many containers
                while image is not None and decoder.ticks is not None and decoder.ticks <= last:
                    yield decoder.ticks, image
                    image = self._next_image(decoder)
                return

    def _next_image(self, decoder: Decoder) -> Optional[np.ndarray]:
        while True:
            try:
                return decoder.read()
            except FrameSkipped:
                self._damaged += 1
