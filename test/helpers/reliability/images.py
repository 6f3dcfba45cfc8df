"""Hostile sensor_msgs/Image and CompressedImage, in process and over the wire."""
import contextlib
import random
import struct
import time
from typing import Dict, Iterator, List, Tuple

import cv2
import numpy as np
from genpy import DeserializationError
from geometry_msgs.msg import Twist
from hypothesis import strategies
from sensor_msgs.msg import CompressedImage, Image

from img_recog.conversions import compressed_image_msgs
from img_recog.conversions.image_msgs import ColorImages, ImageError
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.recognition_settings import with_colors
from img_recog.ros.transport import image_subscriber
from img_recog_helpers import plain_opencv
from img_recog_helpers.process_table import Usage, usage
from img_recog_helpers import wire
from img_recog_helpers.reliability import chain, hostile
from img_recog_helpers.reliability.nodes import Nodes
from img_recog_helpers.waiting import wait_for

_ENCODINGS = ('bgr8', 'rgb8', 'bgra8', 'rgba8', 'mono8', 'mono16', 'bgr16', 'rgb16', 'bayer_rggb8',
              'bayer_grbg16', 'yuv422', 'yuv422_yuy2', '8UC1', '8UC3', '16SC2', '32FC1', '64FC4',
              '8UC0', '8UC999', '', 'BGR8', 'bgr8\0', '\x1b[2J', 'x' * 300, 'h264', '-1UC3')
_FORMATS = ('jpeg', 'png', 'bgr8; jpeg compressed bgr8', 'rgb8; png compressed', 'mono8; jpeg',
            '16UC1; compressedDepth', '', ';', 'bayer_rggb8; png compressed', 'x' * 300)
_SIZES = (0, 1, 2, 3, 7, 16, 33)
_EXTREME = (0x7fffffff, 0x80000000, 0xffffffff, 65536, 0x40000000)
_PER_EXAMPLE = 25
_MAX_S = 1.0            # of CPU time for one image; none has more than some thousand bytes


def _image(drawn, rng: random.Random) -> bytes:
    """Return a serialized Image with some fields from `drawn`, some plausible, some extreme."""
    text, number, data = drawn
    msg = Image()
    msg.header.seq = number
    msg.header.stamp.secs, msg.header.stamp.nsecs = rng.choice(
        ((0, 0), (number, 999999999), (0xffffffff, 0xffffffff), (1, 5)))
    msg.header.frame_id = text
    msg.encoding = rng.choice(_ENCODINGS + (text,)) if rng.random() < 0.7 else 'bgr8'
    msg.height, msg.width = (rng.choice(_SIZES if rng.random() < 0.9 else _EXTREME)
                             for _ in range(2))
    row = msg.width * rng.choice((1, 2, 3, 3, 4, 6, 8))
    msg.step = rng.choice((row, row, row + rng.randrange(9), number)) & 0xffffffff
    msg.is_bigendian = rng.choice((0, 0, 1, 255))
    size = min(msg.step * msg.height, 4096)
    wanted = max(0, size + rng.choice((0, 0, 0, -1, 1, -size)))
    msg.data = (data * (wanted // max(1, len(data)) + 1))[:wanted] if data else bytes(wanted)
    return wire.packet(msg)[4:]


class _Check:
    """Gives images to the conversions and, if they accept them, to the recognition."""

    def __init__(self) -> None:
        self._images, self._settings = ColorImages(), with_colors()()
        self._extractor = ColorExtractor(self._settings)
        self._numbers = iter(range(1 << 62))
        self.accepted = self.refused = self.undecodable = 0
        self.max_s = 0.0

    def raw(self, drawn, rng: random.Random) -> None:
        for _ in range(_PER_EXAMPLE):
            data = _image(drawn, rng)
            if rng.random() < 0.4:
                data = hostile.damaged(data, rng)
            with self._timed(data):
                self._raw(data)

    @contextlib.contextmanager
    def _timed(self, data: bytes) -> Iterator[None]:
        """Refuse an image that costs much time, as one that is unpacked to gigabytes does."""
        begin_s = time.process_time()
        yield
        taken_s = time.process_time() - begin_s
        self.max_s = max(self.max_s, taken_s)
        assert taken_s < _MAX_S, '{:.1f} s for {!r}'.format(taken_s, data)

    def _raw(self, data: bytes) -> None:
        try:
            msg = image_subscriber._image(memoryview(data))
        except (DeserializationError, struct.error, ValueError):
            self.undecodable += 1
            return
        self._same(msg, data)
        try:
            image, encoding = self._images.from_msg(msg)
        except ImageError as error:
            assert '\n' not in str(error)
            self.refused += 1
            return
        self._measure(image, encoding)

    def _same(self, msg: Image, data: bytes) -> None:
        """Compare our reading of the bytes with that of genpy."""
        other = Image().deserialize(data)
        assert msg.data == other.data
        for name in ('header', 'height', 'width', 'encoding', 'is_bigendian', 'step'):
            assert getattr(msg, name) == getattr(other, name), name

    def compressed(self, drawn, rng: random.Random) -> None:
        text, _, data = drawn
        for _ in range(_PER_EXAMPLE):
            if rng.random() < 0.9:
                data = hostile.damaged(rng.choice(_FILES), rng)
            msg = CompressedImage(format=rng.choice(_FORMATS + (text,)), data=data)
            with self._timed(data):
                self._compressed(msg)

    def _compressed(self, msg: CompressedImage) -> None:
        try:
            image = compressed_image_msgs.from_msg(msg)
        except ImageError as error:
            assert '\n' not in str(error)
            self.refused += 1
        else:
            self._measure(image, 'bgr8')

    def _measure(self, image: np.ndarray, encoding: str) -> None:
        areas_px = self._extractor.measure(image, encoding)
        assert image.dtype == np.uint8 and image.ndim == 3
        if encoding == 'bgr8' and next(self._numbers) % 10 == 0:
            assert areas_px == [int(np.count_nonzero(plain_opencv.mask(image, color)))
                                for color in self._settings.colors]
        self.accepted += 1


def _files() -> List[bytes]:
    """Return small images, most of them in the formats that a message may have."""
    ramp = np.arange(12 * 16 * 3, dtype=np.uint8).reshape(12, 16, 3)
    wide, grey = ramp.astype(np.uint16) * 200, ramp[..., 0]
    files = [cv2.imencode(ending, image)[1].tobytes()
             for ending, image in (('.jpg', ramp), ('.jpg', grey), ('.png', ramp), ('.png', grey),
                                   ('.png', np.dstack([ramp, grey])), ('.png', wide),
                                   ('.png', wide[..., 0]), ('.bmp', ramp), ('.tiff', ramp),
                                   ('.webp', ramp))]
    return [*files, cv2.imencode('.jpg', ramp, [cv2.IMWRITE_JPEG_PROGRESSIVE, 1])[1].tobytes()]


_FILES = _files()
_STRATEGY = strategies.tuples(strategies.text(max_size=12), strategies.integers(0, 0xffffffff),
                              strategies.binary(max_size=64))


def in_process(count: int, seed: int) -> Dict[str, float]:
    """Give `count` images to conversions and recognition, half of them compressed."""
    check = _Check()
    examples = max(1, count // _PER_EXAMPLE // 2)
    with hostile.quiet_libraries():
        hostile.explore(examples, seed, _STRATEGY, check.raw)
        hostile.explore(examples, seed + 1, _STRATEGY, check.compressed)
    return {'accepted': check.accepted, 'refused': check.refused,
            'undecodable': check.undecodable, 'max_s': round(check.max_s, 2)}


def over_the_wire(count: int, seed: int, nodes: Nodes) -> Dict[str, int]:
    """Send `count` images of any bytes to running nodes, which have to see colors afterwards.

    One node gets raw images, the other one compressed images.
    """
    rng = random.Random(seed)
    publishers, processes = [], []
    for namespace, transport, data_class, topic in (
            ('raw', 'raw', Image, '/usb_cam/image_raw'),
            ('compressed', 'compressed', CompressedImage, '/usb_cam/image_raw/compressed')):
        processes.append(nodes.start_node('color_img_recog.py', '__ns:=' + namespace,
                                          '_image_transport:=' + transport))
        publishers.append(wire.RawPublisher(nodes.master_uri, '/' + namespace + topic,
                                            data_class, '/camera_' + namespace))
    try:
        for publisher in publishers:
            wait_for(publisher.get_num_connections, lambda: nodes.output()[-2000:])
        before = [_recognizes(nodes, *each) for each in zip(publishers, processes)]
        for number in range(count // 2):
            drawn = ''.join(chr(rng.randrange(0xd7ff)) for _ in range(rng.randrange(8))), \
                rng.randrange(1 << 32), bytes(rng.randrange(256) for _ in range(32))
            data = _image(drawn, rng)
            data = hostile.damaged(data, rng) if rng.random() < 0.5 else data
            assert publishers[0].send(wire.framed(data)) == 1, 'it has hung up'
            msg = CompressedImage(format=rng.choice(_FORMATS),
                                  data=hostile.damaged(rng.choice(_FILES), rng))
            assert publishers[1].publish(msg) == 1, 'it has hung up'
            time.sleep(0.001)
            if number % 500 == 499:
                for each in zip(publishers, processes):
                    _recognizes(nodes, *each)
        after = [_recognizes(nodes, *each) for each in zip(publishers, processes)]
        growth = [end.rss_mb - begin.rss_mb for begin, end in zip(before, after)]
        assert max(growth) < 60, growth
    finally:
        for publisher in publishers:
            publisher.close()
    return {'sent': count // 2 * 2, 'rss_growth_mb': round(max(growth))}


def _good(data_class: type, color: str):
    if data_class is Image:
        return chain.message(color)
    data = cv2.imencode('.png', chain.frame(color))[1].tobytes()
    return CompressedImage(format='png', data=data)


def _recognizes(nodes: Nodes, publisher: wire.RawPublisher, process) -> Usage:
    """Wait until a node gives the command for each color; return what it uses."""
    namespace = publisher.topic.split('/')[1]
    data_class = CompressedImage if namespace == 'compressed' else Image
    commands = nodes.subscribe('/{}/color_extract'.format(namespace),
                               '/{}/cmd_vel'.format(namespace), Twist)
    expected: Tuple[Tuple[str, float], ...] = (('blue', 10.0), ('red', -10.0))
    try:
        for color, speed in expected:
            def recognized():
                publisher.publish(_good(data_class, color))
                time.sleep(0.05)
                return any(msg.linear.x == speed for msg in commands.read())
            wait_for(recognized, lambda: '{}\n{}'.format(color, process.output[-2000:]))
    finally:
        commands.close()
    return usage(process.pid)
