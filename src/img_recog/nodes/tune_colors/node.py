"""The tuning picture of a topic, which may follow topic and parameters."""
import argparse
import os
import time
from typing import Optional

import numpy as np
import rospy
from sensor_msgs.msg import Image

from img_recog import files
from img_recog.conversions import compressed_image_msgs, image_msgs
from img_recog.errors import UserError
from img_recog.nodes import color_parameters
from img_recog.nodes.tune_colors.output import PictureOutput
from img_recog.recognition import parameter_file
from img_recog.recognition.settings import RecognitionSettings
from img_recog.ros import image_topics, parameters
from img_recog.ros.queues import LatestValue
from img_recog.ros.throttle import Throttle, ThrottledWarning
from img_recog.settings import ParameterError

_NODE = '/color_extract'
_WINDOW_PERIOD_S, _FILE_PERIOD_S, _POLL_PERIOD_S = 0.5, 1.0, 0.05
_NICENESS = 10
_BUFFER_BYTES = 1 << 26         # above the size of an image, or rospy falls behind


class TopicTuning:
    """Pictures of the newest image of a topic.

    Subscribes: that topic (sensor_msgs/Image or sensor_msgs/CompressedImage). Publishes nothing.
    Reads: the parameters of the node that recognizes colors (RecognitionSettings).
    """

    def __init__(self, topic: str, kind: type, options: argparse.Namespace,
                 picture: PictureOutput):
        """Subscribe.

        topic: a resolved name; kind: Image or CompressedImage.
        options: timeout in s, watch, colors (a path or None) and node (a name or None).
        Raises ParameterError when the colors cannot be read.
        """
        self._topic, self._options, self._picture = topic, options, picture
        self._decode = (image_msgs if kind is Image else compressed_image_msgs).from_msg
        self._settings = self._read_settings()
        self._frames = LatestValue()
        self._warn = ThrottledWarning()
        self._subscriber = rospy.Subscriber(topic, kind, self._frames.put, queue_size=1,
                                            buff_size=_BUFFER_BYTES, tcp_nodelay=True)

    def spin(self) -> None:
        """Draw one picture, and follow the topic while there is somebody to see it."""
        os.nice(_NICENESS)      # drawing must not slow down the nodes that are looked at
        try:
            image = self._first()
            if image is None:
                return
            self._picture.begin(image, self._settings)
            if self._picture.window is not None or self._options.watch:
                self._follow(image)
        finally:
            self._subscriber.unregister()
            if self._picture.window is not None:
                self._picture.window.close()

    def _first(self) -> Optional[np.ndarray]:
        """Return the first image, None when the node is shut down."""
        end_s = time.monotonic() + self._options.timeout
        while not rospy.is_shutdown():
            msg = self._frames.take(_POLL_PERIOD_S)
            if msg is not None:
                return self._decode(msg, 'bgr8')
            if time.monotonic() > end_s:
                raise image_topics.TopicError('no image came on {} within {:g} s; is its camera '
                                              'running, or is --timeout too short?'.format(
                                                  self._topic, self._options.timeout))
        return None

    def _follow(self, image: np.ndarray) -> None:
        window = self._picture.window
        due = Throttle(_WINDOW_PERIOD_S if window else _FILE_PERIOD_S)
        due_file = Throttle(_FILE_PERIOD_S if window else 0.0)
        msg = None
        while not rospy.is_shutdown() and (window is None or window.is_open):
            msg = self._frames.take(_POLL_PERIOD_S) or msg
            if window is not None:
                window.update()
            if not due.ready():
                continue
            try:
                settings = self._read_settings()
                if msg is None and settings == self._settings:
                    continue
                if msg is not None:
                    image, msg = self._decode(msg, 'bgr8'), None
            except UserError as error:
                self._warn('the picture stays as it is: %s', error)
                continue
            self._settings = settings
            self._picture.draw(image, settings)
            if self._options.watch and due_file.ready():
                self._picture.save()

    def _read_settings(self) -> RecognitionSettings:
        if self._options.colors:
            return parameter_file.read(files.find_user_path(self._options.colors))
        node = rospy.resolve_name(self._options.node or _NODE)
        if self._options.node and not parameters.names_in(node):
            raise ParameterError('there are no parameters of a node {}: start it, or give '
                                 'its parameter file by --colors'.format(node))
        return color_parameters.read(node)
