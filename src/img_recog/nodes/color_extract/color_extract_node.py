"""The node color_extract: commands the robot by the colors in images.

Subscribes to usb_cam/image_raw (sensor_msgs/Image, any encoding that cv_bridge converts to bgr8)
or, if ~image_transport is compressed, to usb_cam/image_raw/compressed
(sensor_msgs/CompressedImage).
Publishes for each processed frame: cmd_vel (geometry_msgs/Twist, one message for each color above
its area limit: linear.x 10 m/s for blue, then -10 m/s for red); a line with the areas on /rosout,
whose time is before the commands; then blue_image and red_image
(sensor_msgs/Image, bgr8, with the header of the frame: the frame with all other pixels black).
Only if there are subscribers: color_detection (sensor_msgs/PointCloud: areas and centroids) and
color_overlay (sensor_msgs/Image, bgr8: the frame with outlines and commands). ~processed
(std_msgs/Header: that of each frame, after all else, also of one that cannot be used).
/diagnostics (diagnostic_msgs/DiagnosticArray) at 1 Hz of wall time.
Reads ~image_transport (raw or compressed), ~max_image_pixels, ~colors_file (the file from which
the parameters were loaded, to check it), ~colors (names), ~NAME_image_topic for each color, and
RecognitionSettings with these colors. The latter can be changed by dynamic_reconfigure
(~set_parameters, ~parameter_descriptions, ~parameter_updates). Serves ~yield (std_srvs/Trigger):
publishes no commands for 0.5 s.
"""
import math
import threading
import time
from dataclasses import dataclass
from functools import partial
from typing import Any, Callable, List, Optional, Sequence, Tuple, Type, Union

import cv2
import rosgraph.names
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from geometry_msgs.msg import Twist
from sensor_msgs.msg import CompressedImage, Image, PointCloud
from std_msgs.msg import Header

from img_recog import files
from img_recog.camera_arguments import CAMERA_TOPIC
from img_recog.conversions import color_detection_msgs, compressed_image_msgs, twist_msgs
from img_recog.conversions.image_msgs import ColorImages, ImageError
from img_recog.errors import shortened
from img_recog.formats.still_images import ALLOWED_MAX_PIXELS, DEFAULT_MAX_PIXELS
from img_recog.recognition import overlay, parameter_file
from img_recog.recognition.areas import ColorExtractor
from img_recog.recognition.commands import POLL_PERIOD_S, Command, Commander
from img_recog.recognition.parameter_file import COLORS, IMAGE_TOPIC, unknown_color
from img_recog.recognition.recognition_settings import (DEFAULT_COLORS, RecognitionSettings,
                                                        color_in, color_names, with_colors)
from img_recog.ros import lifecycle, parameters
from img_recog.ros.diagnostics import (MIN_SHARE, Durations, EventCounter, NodeDiagnostics,
                                       Refusals, add_counter, add_durations, add_refusals)
from img_recog.ros.queues import LatestValue
from img_recog.ros.reconfigure import Reconfigurable
from img_recog.ros.throttle import ChangeThrottle, ThrottledWarning
from img_recog.ros.transport.direct_publisher import DirectPublisher
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.ros.transport.image_subscriber import ImageSubscriber
from img_recog.ros.transport.rosout import RecurringLine
from img_recog.ros.yielding import Yielding
from img_recog.settings import SettingError, Settings, one_of, setting

_STALE_S = 2.0          # without an image: longer is a warning
_MAX_LATENCY_S = 60.0   # a larger one is an image with old stamps, as of a bag
TRANSPORTS = ('raw', 'compressed')      # names as in image_transport
# Processing is too slow for the thread that receives if an image takes longer, or if more wait in
# its socket; it is left to the loop for this time.
_MAX_PROCESSING_S, _MAX_WAITING = 0.03, 1
_LATE_S = 1.0
_TOPICS = (CAMERA_TOPIC, 'cmd_vel', 'color_detection', 'color_overlay', '/rosout')
# a frame of 640x480 takes 5 % less CPU time if the loop waits so long unless lost colors stop the
# robot
_NO_POLL_S = 60.0


class RecognitionDiagnostics:
    """Counters of the node, and their report.

    topic: of the images.
    received: images that arrived; replaced: those of them that a newer one replaced before they
    were processed; refused: those that could not be used; processed: the others.
    commands: published on cmd_vel.
    processing: of an image, from taking it to the last result; latency: from the stamp of an
    image to its commands, in ROS time.
    """

    def __init__(self, topic: str, now: Callable[[], float] = time.monotonic):
        """Start to count.

        topic: of the images.
        """
        self.topic, self._now = topic, now
        self.received, self.replaced = EventCounter(now), EventCounter(now)
        self.processed, self.commands = EventCounter(now), EventCounter(now)
        self.refused = Refusals()
        self.processing, self.latency = Durations(), Durations()
        self._reported, self._last_s = 0, now()

    def count_latency(self, now_s: float, stamp_s: float) -> None:
        """Count the time from the stamp of an image to now, if both are of the same clock."""
        if stamp_s > 0 and 0.0 <= now_s - stamp_s <= _MAX_LATENCY_S:
            self.latency.add(now_s - stamp_s)

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in the status; to be called once in each period."""
        received = self.received.total
        if received != self._reported:
            self._reported, self._last_s = received, self._now()
        received_hz = add_counter(status, 'images received', self.received)
        status.add('images replaced by newer ones', str(self.replaced.total))
        processed_hz = add_counter(status, 'images processed', self.processed)
        add_counter(status, 'commands', self.commands)
        add_durations(status, 'processing', self.processing)
        add_durations(status, 'stamp to commands', self.latency)
        replaced_hz = self.replaced.rate_hz()
        status.summary(*self._summary(received_hz, replaced_hz, processed_hz))
        if add_refusals(status, 'images', self.refused) and processed_hz == 0:
            status.mergeSummary(DiagnosticStatus.ERROR, 'no image can be used: check the camera')

    def _summary(self, received_hz: float, replaced_hz: float, processed_hz: float
                 ) -> Tuple[int, str]:
        silent_s = self._now() - self._last_s
        if silent_s > _STALE_S:
            return DiagnosticStatus.WARN, 'no images on {} {}: start a camera'.format(
                self.topic, 'for {:.0f} s'.format(silent_s) if self._reported else 'yet')
        if replaced_hz > (1 - MIN_SHARE) * received_hz:
            return DiagnosticStatus.WARN, ('too slow: {:.1f} of {:.1f} images a second are '
                                           'processed; use a smaller image or rate'.format(
                                               processed_hz, received_hz))
        return DiagnosticStatus.OK, '{:.1f} Hz'.format(processed_hz)


class ImageInput:
    """Subscribes to images, raw or compressed.

    A raw image is processed in the thread that receives it: this saves the change to another
    thread. When that takes too long for the rate of the images, it is left to the loop for a
    while, so that images are received meanwhile and the loop gets the newest. Decoding a
    compressed image takes long: all are left to the loop.

    take, wake: those of a LatestValue with the message that is left to the loop.
    decode: returns the image of a message, and its encoding; raises ImageError.
    """

    def __init__(self, topic: str, transport: str, counts: RecognitionDiagnostics, max_pixels: int,
                 process: Callable[[Image], bool], now: Callable[[], float] = time.monotonic):
        """Subscribe.

        topic: of the raw images; transport: one of TRANSPORTS.
        max_pixels: larger images are refused, compressed ones before they are decoded.
        process: is called with an image, in any thread; returns whether it was processed. If it
        was not, the image is left to the loop.
        """
        self._counts, self._process, self._now = counts, process, now
        self._latest = LatestValue()
        self.take, self.wake = self._latest.take, self._latest.wake
        if transport == 'raw':
            self._late_until_s = now()
            self.decode = ColorImages(max_pixels).from_msg
            ImageSubscriber(topic, self._receive, counts.refused.add)
        else:
            self._late_until_s = math.inf
            self.decode = lambda msg: (compressed_image_msgs.from_msg(msg, max_pixels), 'bgr8')
            rospy.Subscriber(rospy.resolve_name(topic) + '/compressed', CompressedImage,
                             self._receive, queue_size=1, buff_size=1 << 24, tcp_nodelay=True)

    def done(self, seconds: float) -> None:
        """Take note of how long the processing of an image took."""
        if seconds > _MAX_PROCESSING_S:
            self._be_late()

    def _receive(self, msg: Union[Image, CompressedImage]) -> None:
        self._counts.received.add()
        if getattr(msg, 'waiting', 0) > _MAX_WAITING:       # plain rospy does not know it
            self._be_late()
        if self._now() < self._late_until_s or not self._process(msg):
            if self._latest.put(msg) is not None:
                self._counts.replaced.add()
                self._be_late()

    def _be_late(self) -> None:
        self._late_until_s = max(self._late_until_s, self._now() + _LATE_S)


def read(namespace: str = '~') -> RecognitionSettings:
    """Return the settings given by the parameters of a node, with the colors in ~colors.

    namespace: the resolved name of the node, if it is not this one.
    Raises ParameterError naming the parameter, its value and the allowed values.
    """
    names = parameters.read_one(COLORS, list(DEFAULT_COLORS), color_names, namespace)
    return parameters.read(with_colors(names), namespace=namespace)


def read_image_topics(settings: RecognitionSettings, used_topics: Sequence[str]) -> List[str]:
    """Return for each color the topic of its masked images, by default NAME_image.

    used_topics: topics that the node already uses.
    Raises ParameterError for a topic name that is invalid or already used.
    """
    used = {rospy.resolve_name(topic) for topic in used_topics}

    def checked(parameter: str, topic: Any) -> str:
        if not (isinstance(topic, str) and topic and rosgraph.names.is_legal_name(topic)):
            raise SettingError(parameter, topic, 'a valid topic name')
        if rospy.resolve_name(topic) in used:
            raise SettingError(parameter, topic, 'a topic that this node does not already use')
        used.add(rospy.resolve_name(topic))
        return topic
    topic_parameters = (IMAGE_TOPIC.format(name) for name in settings.color_names)
    return [parameters.read_one(parameter, name + '_image', partial(checked, parameter))
            for parameter, name in zip(topic_parameters, settings.color_names)]


def warn_of_unknown(settings: RecognitionSettings, *others: Type[Settings]) -> None:
    """Log one warning for each private parameter that the node does not have.

    others: the other settings of the node.
    """
    known = [COLORS, *(IMAGE_TOPIC.format(name) for name in settings.color_names)]
    of_unknown_colors = []
    for name in parameters.names_in('~'):
        color = color_in(name)
        if color is not None and color not in settings.color_names:
            of_unknown_colors.append(name)
            rospy.logwarn('parameter %s: %s', shortened(rospy.resolve_name('~' + name)),
                          unknown_color(color, settings.color_names))
    parameters.warn_of_unknown(type(settings), *others, also_known=known + of_unknown_colors)


@dataclass(frozen=True)
class InputSettings(Settings):
    """Parameters of the node itself.

    image_transport: name of the transport of the images, as in image_transport.
    colors_file: the file from which a launch file has loaded the parameters. It is checked because
    roslaunch silently loads nothing from an empty file.
    max_image_pixels: an image with more pixels is refused, a compressed one before it is decoded.
    """

    image_transport: str = setting('raw', one_of(*TRANSPORTS))
    colors_file: str = setting('')
    max_image_pixels: int = setting(DEFAULT_MAX_PIXELS, ALLOWED_MAX_PIXELS)


class ColorExtract:
    """Processes the newest frame; a slow node drops frames."""

    def __init__(self) -> None:
        given = parameters.read(InputSettings)
        if given.colors_file:
            parameter_file.read(files.find_user_path(given.colors_file))
        settings = read()
        topics = read_image_topics(settings, _TOPICS)
        warn_of_unknown(settings, InputSettings)
        self._extractor = ColorExtractor(settings)
        self._commander = Commander(settings, time.monotonic())
        self._settings = settings
        self._warn = ThrottledWarning()
        self._shown, self._line = ChangeThrottle(1.0), RecurringLine()
        transport = given.image_transport
        self._counts = counts = RecognitionDiagnostics(rospy.resolve_name(CAMERA_TOPIC) + (
            '' if transport == 'raw' else '/' + transport))
        self._velocity, self._yielding = DirectPublisher('cmd_vel', Twist), Yielding()
        self._masked = [ImagePublisher(topic) for topic in topics]
        self._detection = rospy.Publisher('color_detection', PointCloud, queue_size=1)
        self._overlay = ImagePublisher('color_overlay')
        self._processed = DirectPublisher('~processed', Header)
        self._is_shutdown = threading.Event()
        self._frame_lock = threading.Lock()
        self._failure: Optional[Exception] = None       # of another thread, for the loop
        lifecycle.on_shutdown(self._shutdown)
        with self._frame_lock:      # images may come before it returns
            self._input = ImageInput(CAMERA_TOPIC, transport, counts, given.max_image_pixels,
                                     self.process)
        Reconfigurable(settings, self._configure)
        lifecycle.on_shutdown(self._input.wake)
        NodeDiagnostics('recognition', 'none', counts.report)
        lifecycle.warn_later(lambda: not counts.received.total, 'no image on {} yet: start a '
                             'camera'.format(counts.topic))

    def spin(self) -> None:
        """Process what is left to the loop until the node is shut down."""
        while not self._is_shutdown.is_set():
            msg = self._input.take(
                POLL_PERIOD_S if self._settings.stop_when_lost else _NO_POLL_S)
            if self._failure is not None:
                raise self._failure
            with self._frame_lock:
                if self._is_shutdown.is_set():
                    return
                if msg is None:
                    self._publish_commands(self._commander.wait(time.monotonic()))
                else:
                    self._process(msg)

    def process(self, msg: Image) -> bool:
        """Process a frame in another thread than the loop; wait while that one is at work.

        Returns whether it was processed, which it is not after the shutdown.
        """
        with self._frame_lock:
            if self._is_shutdown.is_set():
                return False
            try:
                self._process(msg)
            except Exception as error:
                self._failure = error
                self._input.wake()
                return False
        return True

    def _process(self, msg: Union[Image, CompressedImage]) -> None:
        begin_s = time.perf_counter()
        self.handle(msg)
        self._processed.publish(msg.header)
        self._input.done(time.perf_counter() - begin_s)

    def handle(self, msg: Union[Image, CompressedImage]) -> None:
        """Recognize the colors in a frame and publish the results."""
        begin_s = time.perf_counter()
        try:
            areas_px = self._extractor.measure(*self._input.decode(msg))
        except ImageError as error:
            self._counts.refused.add(error)
            self._warn('frame skipped: %s', error)
            return
        commands = self._commander.decide(areas_px, time.monotonic())
        # The line has its time before the commands, as in the article. Writing it, and all else,
        # comes after them, so that it does not delay them.
        self._line.take_time()
        self._publish_commands(commands)
        self._counts.count_latency(rospy.get_time(), msg.header.stamp.to_sec())
        # the terminal has only the lines of frames with other commands
        self._line.write(', '.join('{}={}'.format(name, area_px) for name, area_px
                                   in zip(self._settings.color_names, areas_px)),
                         self._shown.shows(self._commander.frame_commands))
        self._publish_images(msg.header, areas_px, commands)
        self._counts.processed.add()
        self._counts.processing.add(time.perf_counter() - begin_s)

    def _publish_images(self, header: Header, areas_px: Sequence[int],
                        commands: Sequence[Command]) -> None:
        """Publish what is for viewers."""
        for number, publisher in enumerate(self._masked):
            publisher.publish_drawn(partial(self._extractor.draw_masked, number),
                                    self._extractor.shape, 'bgr8', header)
        if self._detection.get_num_connections() > 0:
            centroids = [self._extractor.centroid(number) for number in range(len(areas_px))]
            self._detection.publish(color_detection_msgs.to_msg(
                self._settings.color_names, areas_px, centroids, header))
        if self._overlay.get_num_connections() > 0:
            image = overlay.draw(self._extractor, self._settings.colors, areas_px, commands)
            self._overlay.publish(image, 'bgr8', header)

    def _publish_commands(self, commands: List[Command]) -> None:
        if self._yielding.is_active():
            self._commander.notify_dropped(commands)
            return
        for command in commands:
            self._velocity.publish(twist_msgs.to_msg(*command))
            self._counts.commands.add()

    def _configure(self, settings: RecognitionSettings) -> None:
        with self._frame_lock:
            self._settings = settings
            self._extractor.configure(settings)
            self._commander.configure(settings)
        self._input.wake()

    def _shutdown(self) -> None:
        self._is_shutdown.set()
        with self._frame_lock:      # nothing is published after this
            self._publish_commands(self._commander.end())


def main() -> int:
    """Run the node; return its exit code."""
    # the threads of OpenCV wait in a busy loop, which costs more CPU time than they save
    cv2.setNumThreads(1)
    return lifecycle.run('color_extract', lambda: ColorExtract().spin(),
                         {'~': (InputSettings, with_colors())})
