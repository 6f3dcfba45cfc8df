"""The images in a bag, as frames."""
from collections import deque
from functools import partial
from typing import TYPE_CHECKING, Any, Callable, Deque, Dict, Iterator, List, NamedTuple, Optional

import genpy
import numpy as np
from sensor_msgs.msg import CameraInfo, CompressedImage, Image
from std_msgs.msg import Header

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.conversions.image_msgs import ImageError
from img_recog.errors import UserError
from img_recog.formats.still_images import DEFAULT_MAX_PIXELS
from img_recog.recordings.bag_file import DAMAGE_ERRORS, damaged, open_bag
from img_recog.recordings.frames import SECOND_NS, WANTED, Frame, Frames, Part
from img_recog.recordings.recording_names import DEFAULT_TOPICS

if TYPE_CHECKING:
    from img_recog.recordings.camera_infos import CameraInfos

_MAX_GAP_S = 3600           # between two stamps
_UNSTAMPED_BYTES = 50000000     # of images that wait for the next stamp
_COMPRESSED = '/compressed'     # added by image_transport
_MESSAGE_TYPES = {message_type._type: message_type for message_type in (Image, CompressedImage)}
_RECORD_ADVICE = 'record one with images: rosbag record ' + DEFAULT_TOPICS[0]


class Decoded(NamedTuple):
    """An image, uint8 of shape (height, width, 3 or 4), and its encoding."""

    image: np.ndarray
    encoding: str


class BagFrames(Frames):
    """The images on one topic of a bag, at the times of their stamps.

    bag: open until all images were read; topic: of the images; message_type: class of their
    messages; period_ns: the mean of all periods, known after the last frame.
    """

    def __init__(self, path: str, topic: str = '', max_pixels: int = DEFAULT_MAX_PIXELS,
                 part: Optional[Part] = None, advice: str = WANTED):
        """Open a bag.

        topic: topic of the images; if empty, one of DEFAULT_TOPICS or the only topic with images.
        max_pixels: images with more pixels are skipped. part: to read only this one; it has the
        topic. advice: what to give in place of a file that is no bag.
        Raises UserError if the file cannot be read as a bag or has no such images.
        """
        self._part = part
        self.bag = open_bag(path, max_pixels, advice)
        try:
            types = self._image_topics(path)
            self.topic = _choose_topic(path, types, part.topic if part else topic)
        except UserError:
            self.bag.close()
            raise
        super().__init__(path, self.topic)
        self.message_type: type = _MESSAGE_TYPES[types[self.topic]]
        self._decode: Callable[[Any], Decoded] = partial(
            _decode_raw if self.message_type is Image else _decode_compressed,
            max_pixels=max_pixels)
        recorded = len(self.times_ns())
        self.expected = part.frames if part else recorded
        self.period_ns = 0
        if not (part and part.first):
            self.note(warnings=self.bag.remarks([self.topic]))

    def _image_topics(self, path: str) -> Dict[str, str]:
        """Return the message types of the topics whose messages are images as defined here."""
        try:
            types, topics = self.bag.get_type_and_topic_info()
        except DAMAGE_ERRORS as error:
            raise damaged(path, error)
        return {name: topic.msg_type for name, topic in sorted(topics.items())
                if topic.msg_type in _MESSAGE_TYPES
                and types[topic.msg_type] == _MESSAGE_TYPES[topic.msg_type]._md5sum}

    def camera_infos(self) -> 'CameraInfos':
        """Return those beside the images; without any, of a camera that is not calibrated.

        To be called before iterating. Raises UserError if the bag is damaged.
        """
        # imported here because few need it
        from img_recog.recordings.camera_infos import recorded
        images = self.topic[:-len(_COMPRESSED)] if self.topic.endswith(_COMPRESSED) else self.topic
        topic = images.rpartition('/')[0] + '/camera_info'
        try:
            return recorded(self.bag.messages({topic: CameraInfo}))
        except DAMAGE_ERRORS as error:
            raise damaged(self.path, error)

    def read(self) -> Iterator[Frame]:
        """Yield the usable images, in the order of the recording.

        Raises UserError if the bag is damaged or its stamps jump.
        """
        first = number = self._part.first if self._part else 0
        first_ns = last_ns = 0
        with self.bag:
            for number, (msg, stamp_ns) in enumerate(self._messages(), first):
                if stamp_ns < 0:
                    self.note(skipped=1, first='message {}: its stamp is of the time before the '
                              'restart'.format(number))
                    continue
                if last_ns:
                    self.check_gap(number, last_ns, stamp_ns)
                first_ns, last_ns = first_ns or stamp_ns, stamp_ns
                decoded = self.decoded(number, msg)
                if decoded is not None:
                    header = Header(msg.header.seq, msg.header.stamp, msg.header.frame_id)
                    yield Frame(number, stamp_ns, header, *decoded)
        self.period_ns = round((last_ns - first_ns) / max(1, number - first))

    def decoded(self, number: int, msg: Any) -> Optional[Decoded]:
        """Return the image of a message, or note why it cannot be used and return None."""
        try:
            found = self._decode(msg)
        except ImageError as error:
            self.note(skipped=1, first='message {}: {}'.format(number, error))
            return None
        self.note(used=1)
        return found

    def times_ns(self) -> List[int]:
        """Return when each image was recorded; no chunk is read."""
        try:
            return self.bag.times_ns({self.topic: self.message_type})
        except DAMAGE_ERRORS as error:
            raise damaged(self.path, error)

    def _messages(self) -> Iterator[Any]:
        """Yield each message and its stamp in ns, or its time of recording if the stamp is 0.

        Images without a stamp are not newer than the next image with one, as far as they take
        _UNSTAMPED_BYTES. The stamp of an image from before a restart of simulated time is -1.
        """
        ends = [genpy.Time(*divmod(time_ns, SECOND_NS)) for time_ns in (
            self._part.begin_ns, self._part.end_ns)] if self._part else []
        unstamped: Deque[Any] = deque()     # the messages before
        size = 0
        try:
            for _, msg, time, _ in self.bag.messages({self.topic: self.message_type}, *ends):
                stamp_ns, time_ns = msg.header.stamp.to_nsec(), time.to_nsec()
                if stamp_ns > time_ns + SECOND_NS and self.topic in self.bag.left_out:
                    stamp_ns = -1
                if not stamp_ns:
                    unstamped.append((msg, time_ns))
                    size += len(msg.data)
                while unstamped and (stamp_ns > 0 or size > _UNSTAMPED_BYTES):
                    before, before_ns = unstamped.popleft()
                    size -= len(before.data)
                    yield before, min(before_ns, stamp_ns or before_ns)
                if stamp_ns:
                    yield msg, stamp_ns
            yield from unstamped
        except DAMAGE_ERRORS as error:
            raise damaged(self.path, error)

    def check_gap(self, number: int, last_ns: int, stamp_ns: int) -> None:
        """Raise UserError if the times of message `number` and the one before it jump."""
        gap_s = (stamp_ns - last_ns) / SECOND_NS
        if not 0 <= gap_s <= _MAX_GAP_S:
            raise UserError(
                'the times of {} in {} jump {} by {:g} s at message {}'.format(
                    self.topic, self.path, 'back' if gap_s < 0 else 'ahead', abs(gap_s), number),
                'extract a part without jumps by rosbag filter')


def _choose_topic(path: str, types: Dict[str, str], topic: str) -> str:
    """Return the topic of the images.

    types: the message type of each topic with images; topic: given by the user, or empty.
    Raises UserError, with the topics in the bag, if there is no such topic or more than one.
    """
    available = 'image topics in it: {}'.format(', '.join(types) or 'none')
    if topic:
        full_name = '/' + topic.lstrip('/')
        if topic in types or full_name in types:
            return topic if topic in types else full_name
        raise UserError('the bag {} has no images on {} ({})'.format(path, topic, available),
                        'set --topic to one of them')
    defaults = [name for name in DEFAULT_TOPICS if name in types]
    if defaults or len(types) == 1:
        return (defaults or list(types))[0]
    if not types:
        raise UserError('the bag {} has no messages of type sensor_msgs/Image or '
                        'sensor_msgs/CompressedImage'.format(path), _RECORD_ADVICE)
    raise UserError('the bag {} has images on several topics, but not on {} ({})'.format(
        path, DEFAULT_TOPICS[0], available), 'choose one of them with --topic')


def _decode_raw(msg: Any, max_pixels: int) -> Decoded:
    # a new ColorImages for each: frames are read ahead and must not share a buffer
    return Decoded(*image_msgs.ColorImages(max_pixels).from_msg(msg))


def _decode_compressed(msg: Any, max_pixels: int) -> Decoded:
    return Decoded(compressed_image_msgs.from_msg(msg, max_pixels), 'bgr8')
