"""The node tune_colors: draws the tuning picture of the images on a topic."""
import argparse
import os
import time
from functools import partial
from typing import Any, Callable, Optional

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
from img_recog.ros.log.throttle import Throttle, ThrottledWarning
from img_recog.ros.queues import LatestValue
from img_recog.settings import ParameterError

_NODE = '/color_extract'
_WINDOW_PERIOD_S, _FILE_PERIOD_S, _POLL_PERIOD_S = 0.5, 1.0, 0.05
_NICENESS = 10
_BUFFER_BYTES = 1 << 26         # if smaller than an image, rospy falls behind


class TuneColorsNode:
    """Draws the newest image of a topic, once or repeatedly.

    Subscribes to that topic (sensor_msgs/Image or sensor_msgs/CompressedImage). Publishes nothing.
    Reads the parameters of the node color_extract (RecognitionSettings).
    """

    def __init__(self, topic: str, message_type: type, options: argparse.Namespace,
                 picture: PictureOutput):
        """Read the colors and subscribe.

        topic: a resolved name; message_type: Image or CompressedImage.
        options: timeout in s, watch, max_image_pixels, colors (a path or None) and node (a name or
        None).
        Raises ParameterError if the colors cannot be read.
        """
        self._topic, self._options, self._picture = topic, options, picture
        self._decode: Callable[[Any, str], np.ndarray] = image_msgs.from_msg
        if message_type is not Image:
            self._decode = partial(compressed_image_msgs.from_msg,
                                   max_pixels=options.max_image_pixels)
        self._settings = self._read_settings()
        self._latest = LatestValue()
        self._warn = ThrottledWarning()
        self._subscriber = rospy.Subscriber(topic, message_type, self._latest.put, queue_size=1,
                                            buff_size=_BUFFER_BYTES, tcp_nodelay=True)

    def spin(self) -> None:
        """Draw one picture; with a window or --watch, redraw it for new images and parameters."""
        os.nice(_NICENESS)      # drawing must not slow down the nodes that are observed
        try:
            image = self._first_image()
            if image is None:
                return
            self._picture.begin(image, self._settings)
            if self._picture.window is not None or self._options.watch:
                self._follow(image)
        finally:
            self._subscriber.unregister()
            if self._picture.window is not None:
                self._picture.window.close()

    def _first_image(self) -> Optional[np.ndarray]:
        """Return the first image, None if the node is shut down.

        Raises TopicError if there is none within the timeout.
        """
        end_s = time.monotonic() + self._options.timeout
        while not rospy.is_shutdown():
            msg = self._latest.take(_POLL_PERIOD_S)
            if msg is not None:
                return self._decode(msg, 'bgr8')
            if time.monotonic() > end_s:
                raise image_topics.TopicError('no image received on {} within {:g} s; is its '
                                              'camera running, or is --timeout too short?'.format(
                                                  self._topic, self._options.timeout))
        return None

    def _follow(self, image: np.ndarray) -> None:
        window = self._picture.window
        draw_timer = Throttle(_WINDOW_PERIOD_S if window else _FILE_PERIOD_S)
        save_timer = Throttle(_FILE_PERIOD_S if window else 0.0)
        msg = None
        while not rospy.is_shutdown() and (window is None or window.is_open):
            msg = self._latest.take(_POLL_PERIOD_S) or msg
            if window is not None:
                window.update()
            if not draw_timer.ready():
                continue
            try:
                settings = self._read_settings()
                if msg is None and settings == self._settings:
                    continue
                if msg is not None:
                    image, msg = self._decode(msg, 'bgr8'), None
            except UserError as error:
                self._warn('the picture is not updated: %s', error)
                continue
            self._settings = settings
            self._picture.draw(image, settings)
            if self._options.watch and save_timer.ready():
                self._picture.save()

    def _read_settings(self) -> RecognitionSettings:
        if self._options.colors:
            return parameter_file.read(files.find_user_path(self._options.colors))
        node = rospy.resolve_name(self._options.node or _NODE)
        if self._options.node and not parameters.names_in(node):
            raise ParameterError('there are no parameters of a node {}; start it, or give '
                                 'its parameter file by --colors'.format(node))
        return color_parameters.read(node)
