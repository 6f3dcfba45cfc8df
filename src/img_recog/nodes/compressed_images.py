"""A topic of compressed images for a topic of raw images, like the plugin of image_transport."""
import threading
from typing import Optional, Union

import numpy as np
import rospy
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import Header

from img_recog.conversions import compressed_image_msgs
from img_recog.conversions.compressed_image_msgs import CompressionSettings
from img_recog.conversions.image_msgs import ImageError
from img_recog.ros import lifecycle, parameters
from img_recog.ros.diagnostics import EventCounter
from img_recog.ros.queues import LatestValue
from img_recog.ros.reconfigure import Reconfigurable
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.redelivery import Redelivery

_POLL_S = 0.2


class CompressedImages:
    """Publishes compressed images; compresses only while there is a subscriber.

    Publishes: TOPIC/compressed (sensor_msgs/CompressedImage, with the header of the raw image),
    TOPIC/compressed/parameter_descriptions, TOPIC/compressed/parameter_updates. Serves:
    TOPIC/compressed/set_parameters. Reads: the fields of CompressionSettings as parameters under
    TOPIC/compressed, which can be changed while it runs.

    A separate thread compresses the newest image: PNG may take longer than the period of the
    camera; then images are dropped here, and the raw ones are not delayed.

    sent, dropped: counters of the published and the dropped images.
    """

    def __init__(self, topic: str, redelivery: Optional[Redelivery] = None):
        """Advertise the topic TOPIC/compressed of the raw topic `topic`.

        redelivery: sends the images, from the first subscriber on.
        """
        self._name = name = rospy.resolve_name(topic) + '/compressed'
        settings = parameters.read(CompressionSettings, namespace=name)
        parameters.warn_of_unknown(CompressionSettings, namespace=name)
        self._images, self._closed = LatestValue(), threading.Event()
        self._warn = ThrottledWarning()
        self.sent, self.dropped = EventCounter(), EventCounter()
        self._publisher = publisher(name, CompressedImage, 1, redelivery)
        self._is_kept = redelivery is not None
        self._was_wanted = threading.Event()    # set by any thread, and never cleared
        self._parameters = Reconfigurable(settings, lambda _: None, name)
        self._worker = threading.Thread(target=self._work, daemon=True)
        self._worker.start()

    def is_wanted(self) -> bool:
        """Return whether there is a subscriber, or was one that may come back."""
        is_wanted = self._publisher.get_num_connections() > 0
        if is_wanted:
            self._was_wanted.set()
        return is_wanted or (self._is_kept and self._was_wanted.is_set())

    def publish(self, image: np.ndarray, encoding: str, header: Header) -> None:
        """Send the image if there is a subscriber; return immediately.

        image, encoding: as for `compressed_image_msgs.to_msg`; the image must not be modified
        afterwards.
        """
        if self.is_wanted():
            # a copy, because rospy writes the sequence number of each topic into the header
            copy = Header(seq=header.seq, stamp=header.stamp, frame_id=header.frame_id)
            if self._images.put((image, encoding, copy)) is not None:
                self.dropped.add()

    def close(self) -> None:
        """Remove the topics and the service."""
        self._closed.set()
        self._worker.join()
        self._parameters.close()
        self._publisher.unregister()

    def _work(self) -> None:
        while not (self._closed.is_set() or rospy.is_shutdown()):
            item = self._images.take(_POLL_S)
            if item is not None:
                self._send(*item)

    def _send(self, image: np.ndarray, encoding: str, header: Header) -> None:
        try:
            msg = compressed_image_msgs.to_msg(image, encoding, header, self._parameters.settings)
        except ImageError as error:
            self._warn('%s: %s', self._name, error)
            return
        with lifecycle.until_shutdown():
            self._publisher.publish(msg)
            self.sent.add()


def publisher(topic: str, data_class: type, queue_size: int, redelivery: Optional[Redelivery]
              ) -> Union[rospy.Publisher, DirectPublisher]:
    """Advertise a topic, whose messages are sent by `redelivery`, if there is one."""
    return (rospy.Publisher(topic, data_class, queue_size=queue_size) if redelivery is None
            else DirectPublisher(topic, data_class, redelivery=redelivery))
