"""Images of topics as JPEG, each encoded once for all viewers."""
import threading
import time
from typing import Dict, Iterable, NamedTuple, Optional, Set

import cv2
import numpy as np
import rospy
from sensor_msgs.msg import Image

from img_recog.conversions.image_msgs import ColorImages, ImageError
from img_recog.errors import one_line
from img_recog.ros.queues import LatestValue
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.image_subscriber import ImageSubscriber

RATE_HZ = 15.0
_MAX_WIDTH = 640
RETRY_PERIOD_S = 1.0
_QUALITY = 80
_TO_BGR = {'rgb8': cv2.COLOR_RGB2BGR, 'rgba8': cv2.COLOR_RGBA2BGR, 'bgra8': cv2.COLOR_BGRA2BGR}


class EncodedPicture(NamedTuple):
    """An encoded image; number: of the image, to see whether it is a new one."""

    number: int
    jpeg: bytes


class PictureTopics:
    """Subscribes to the image topics that somebody looks at, and encodes their newest images."""

    def __init__(self) -> None:
        """Subscribe to nothing yet."""
        self._lock = threading.Lock()
        self._allowed: Set[str] = set()
        self._wanted: Set[str] = set()
        self._topics: Dict[str, _Topic] = {}        # of the thread
        self._retry_s: Dict[str, float] = {}        # when a topic that has failed is tried again
        self._thread: Optional[threading.Thread] = None
        self._warn = ThrottledWarning()

    def allow(self, names: Iterable[str]) -> None:
        """Allow that these topics are watched, too."""
        with self._lock:
            self._allowed.update(names)

    def watch(self, names: Set[str]) -> None:
        """Subscribe to these topics, and to no others, soon and in another thread.

        Only to those that are allowed: the names come from browsers, and rospy would take the
        connections of another topic of this node for images, too.
        """
        with self._lock:
            self._wanted = names & self._allowed
            if self._wanted and self._thread is None:
                self._thread = threading.Thread(target=self._run, daemon=True)
                self._thread.start()

    def latest(self, name: str) -> Optional[EncodedPicture]:
        """Return the newest picture of a topic, None if there is none."""
        topic = self._topics.get(name)
        return topic.picture if topic is not None else None

    def image(self, name: str) -> Optional[np.ndarray]:
        """Return a copy of the newest image of a topic in its own size, bgr8; None without one."""
        topic = self._topics.get(name)
        return topic.image() if topic is not None else None

    def _run(self) -> None:
        """Encode the newest images at RATE_HZ, while somebody looks."""
        while not rospy.is_shutdown():
            start_s = time.monotonic()
            with self._lock:
                wanted = self._wanted
                if not wanted and not self._topics:
                    self._thread = None
                    return
            for name in wanted | set(self._topics):
                if start_s >= self._retry_s.get(name, 0.0):
                    self._update(name, name in wanted)
            time.sleep(max(0.0, start_s + 1 / RATE_HZ - time.monotonic()))

    def _update(self, name: str, is_wanted: bool) -> None:
        """Subscribe to a topic, encode its newest image, or unsubscribe."""
        try:
            if not is_wanted:
                self._topics.pop(name).close()
                return
            if name not in self._topics:
                self._topics[name] = _Topic(name)
            self._topics[name].encode()
        except Exception as error:      # one topic must not end the pictures of the others
            self._warn('a picture of %s failed: %s: %s', name, type(error).__name__,
                       one_line(error))
            self._retry_s[name] = time.monotonic() + RETRY_PERIOD_S


class _Topic:
    """A topic with images."""

    def __init__(self, name: str):
        self._latest, self._warn = LatestValue(), ThrottledWarning()
        self._name, self._number, self._images = name, 0, ColorImages()
        self._kept: Optional[Image] = None      # the newest one that was taken, for `image`
        self.picture: Optional[EncodedPicture] = None
        self._subscriber = ImageSubscriber(name, self._latest.put)

    def close(self) -> None:
        self._subscriber.close()

    def encode(self) -> None:
        """Encode the newest image, if there is one that is not encoded yet."""
        msg = self._latest.take()
        if msg is None:
            return
        self._kept = msg
        try:
            image, encoding = self._images.from_msg(msg)
            jpeg = encoded(_as_bgr(_fitted(image), encoding))
        except ImageError as error:
            self._warn('no picture of %s: %s', self._name, error)
            return
        self._number += 1
        self.picture = EncodedPicture(self._number, jpeg)

    def image(self) -> Optional[np.ndarray]:
        """Return a copy of the newest image, bgr8."""
        kept = self._kept
        try:
            return None if kept is None else _as_bgr(*ColorImages().from_msg(kept)).copy()
        except ImageError:
            return None


def encoded(image: np.ndarray) -> bytes:
    """Return a bgr8 image as the JPEG that pages show."""
    return cv2.imencode('.jpg', _fitted(image), (cv2.IMWRITE_JPEG_QUALITY, _QUALITY))[1].tobytes()


def _as_bgr(image: np.ndarray, encoding: str) -> np.ndarray:
    return image if encoding == 'bgr8' else cv2.cvtColor(image, _TO_BGR[encoding])


def _fitted(image: np.ndarray) -> np.ndarray:
    """Return an image that is at most _MAX_WIDTH wide."""
    height, width = image.shape[:2]
    if width <= _MAX_WIDTH:
        return image
    return cv2.resize(image, (_MAX_WIDTH, max(1, round(height * _MAX_WIDTH / width))),
                      interpolation=cv2.INTER_AREA)
