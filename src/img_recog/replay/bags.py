"""The frames of a bag, by the stamps of their messages."""
import struct
from typing import Any, Callable, Dict, Iterator, NamedTuple

import genpy
import numpy as np
import rosbag
from sensor_msgs.msg import CompressedImage, Image
from std_msgs.msg import Header

from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.conversions.image_msgs import ImageError
from img_recog.errors import UserError
from img_recog.replay.chain import SECOND_NS, Frame
from img_recog.replay.inputs import DEFAULT_TOPICS

_LONGEST_GAP_S = 3600
_KINDS = {kind._type: kind for kind in (Image, CompressedImage)}
_DAMAGED = 'the bag {} is damaged: {}; try rosbag reindex, or record it anew'
# what rosbag and genpy let through from a damaged file
_DAMAGE = (rosbag.ROSBagException, genpy.MessageException, struct.error, OSError, EOFError,
           RuntimeError, ValueError, KeyError, AttributeError, TypeError)


class Decoded(NamedTuple):
    """An image, uint8 of shape (height, width, 3 or 4), and its encoding."""

    image: np.ndarray
    encoding: str


class BagFrames:
    """The images on one topic of a bag.

    expected, period_ns, warnings: as those of VideoFrames; the period is the mean one, known at
    the end.
    """

    def __init__(self, path: str, topic: str = ''):
        """Open a bag.

        topic: of the images, without it one of DEFAULT_TOPICS, or the only one that there is.
        Raises UserError when it is no bag that can be read, or has no such images.
        """
        self._path = path
        self._bag = _opened(path)
        try:
            kinds = self._image_topics()
            self.topic = _chosen(path, kinds, topic)
        except UserError:
            self._bag.close()
            raise
        self._decode: Callable[[Any], Decoded] = (
            _decoded if kinds[self.topic] == Image._type else _decompressed)
        self.expected = self._bag.get_message_count(self.topic)
        self.period_ns = 0
        self.warnings = []

    def _image_topics(self) -> Dict[str, str]:
        """Return the topics whose messages are images as they are defined here, with the type."""
        try:
            types, topics = self._bag.get_type_and_topic_info()
        except _DAMAGE as error:
            raise UserError(_DAMAGED.format(self._path, _line(error)))
        return {name: topic.msg_type for name, topic in sorted(topics.items())
                if topic.msg_type in _KINDS
                and types[topic.msg_type] == _KINDS[topic.msg_type]._md5sum}

    def __iter__(self) -> Iterator[Frame]:
        """Yield the images that can be used, in the order of the recording.

        Raises UserError when the bag is damaged, its stamps go back or leap, or none can be used.
        """
        numbers, skipped, first_ns, last_ns = 0, [], None, None
        for number, (msg, stamp_ns) in enumerate(self._messages()):
            if last_ns is not None:
                self._check_stamp(number, last_ns, stamp_ns)
            first_ns, last_ns = stamp_ns if first_ns is None else first_ns, stamp_ns
            try:
                decoded = self._decode(msg)
            except ImageError as error:
                skipped.append('message {}: {}'.format(number, error))
                continue
            header = Header(msg.header.seq, msg.header.stamp, msg.header.frame_id)
            yield Frame(number, stamp_ns, header, *decoded)
            numbers += 1
        self._conclude(numbers, skipped)
        self.period_ns = round((last_ns - first_ns) / max(1, numbers + len(skipped) - 1))

    def _messages(self):
        """Yield each message with the time in ns of its header, or of its record without one."""
        try:
            for _, msg, recorded in self._bag.read_messages(self.topic):
                yield msg, (msg.header.stamp or recorded).to_nsec()
        except _DAMAGE as error:
            raise UserError(_DAMAGED.format(self._path, _line(error)))
        finally:
            self._bag.close()

    def _check_stamp(self, number: int, before_ns: int, stamp_ns: int) -> None:
        gap_s = (stamp_ns - before_ns) / SECOND_NS
        if not 0 <= gap_s <= _LONGEST_GAP_S:
            raise UserError(
                'the stamps of {} in {} {} by {:g} s at message {}; cut out a part that is in one '
                'piece: rosbag filter'.format(self.topic, self._path,
                                              'go back' if gap_s < 0 else 'leap', abs(gap_s),
                                              number))

    def _conclude(self, used: int, skipped: list) -> None:
        if not used:
            raise UserError('no image on {} in {} can be used; {}'.format(
                self.topic, self._path, skipped[0] if skipped else 'there is no message'))
        if skipped:
            self.warnings.append('{} of {} images on {} cannot be used; the first is {}'.format(
                len(skipped), used + len(skipped), self.topic, skipped[0]))


def _opened(path: str) -> rosbag.Bag:
    try:
        return rosbag.Bag(path)
    except rosbag.ROSBagUnindexedException:
        raise UserError('the bag {0} has no index, as when its recording was cut off; make one: '
                        'rosbag reindex {0}'.format(path))
    except _DAMAGE as error:
        raise UserError('cannot read {} as a bag: {}; give a video that OpenCV plays, or a bag '
                        'with images'.format(path, _line(error)))


def _chosen(path: str, kinds: Dict[str, str], topic: str) -> str:
    """Return the topic that is wanted; UserError, with those that there are, without one."""
    have = 'image topics in it: {}'.format(', '.join(kinds) or 'none')
    if topic:
        full_name = '/' + topic.lstrip('/')
        if topic in kinds or full_name in kinds:
            return topic if topic in kinds else full_name
        raise UserError('the bag {} has no images on {} ({}); set --topic to one that it has'
                        .format(path, topic, have))
    usual = [name for name in DEFAULT_TOPICS if name in kinds]
    if usual or len(kinds) == 1:
        return (usual or list(kinds))[0]
    if not kinds:
        raise UserError('the bag {} has no messages of sensor_msgs/Image or CompressedImage; '
                        'record one with images: rosbag record {}'.format(path, DEFAULT_TOPICS[0]))
    raise UserError('the bag {} has images on several topics, none of them {} ({}); choose one '
                    'with --topic'.format(path, DEFAULT_TOPICS[0], have))


def _decoded(msg: Any) -> Decoded:
    # memory of its own for each: frames are read ahead
    return Decoded(*image_msgs.ColorImages().from_msg(msg))


def _decompressed(msg: Any) -> Decoded:
    return Decoded(compressed_image_msgs.from_msg(msg, 'bgr8'), 'bgr8')


def _line(error: Exception) -> str:
    return ' '.join(str(error).split()) or type(error).__name__
