"""The node usb_cam: publishes a camera, a video, images, a stream or the synthetic scene.

Publishes, for each frame and with the same header: ~image_raw (sensor_msgs/Image, rgb8, or mono8
for grey pixel formats of a device), ~image_raw/compressed (sensor_msgs/CompressedImage, only while
it has a subscriber) and ~camera_info (sensor_msgs/CameraInfo), at the rate of the source, in the
frame camera_frame_id; /diagnostics (diagnostic_msgs/DiagnosticArray) at 1 Hz;
~parameter_descriptions and ~parameter_updates (dynamic_reconfigure), also in
~image_raw/compressed.
Subscribes to /clock (rosgraph_msgs/Clock) until the first message, if /use_sim_time is set.
Serves: ~start_capture, ~stop_capture (std_srvs/Empty), ~set_camera_info
(sensor_msgs/SetCameraInfo), ~set_parameters (dynamic_reconfigure). Reads: the fields of
UsbCamSettings and ControlSettings and intrinsic_controls as private parameters, those of
CompressionSettings in ~image_raw/compressed.
"""
import dataclasses
import threading
import time
from typing import Callable, List, Mapping, Optional, Set, Tuple

import numpy as np
import rospy
from diagnostic_msgs.msg import DiagnosticStatus
from diagnostic_updater import DiagnosticStatusWrapper
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from std_srvs.srv import Empty, EmptyRequest, EmptyResponse

from img_recog import files
from img_recog.camera import controls, selection
from img_recog.camera.capture import Capture, Listener
from img_recog.camera.controls import SETTINGS, ControlDevice
from img_recog.camera.frame_pacing import Stamps
from img_recog.camera.source import FrameSource, redacted
from img_recog.camera.usb_cam_settings import ControlSettings, UsbCamSettings, intrinsic_controls
from img_recog.conversions.compressed_image_msgs import CompressionSettings
from img_recog.errors import named_in_crashes, one_line
from img_recog.nodes.compressed_images import CompressedImages
from img_recog.nodes.usb_cam.camera_info import CameraCalibration
from img_recog.ros import lifecycle, parameters
from img_recog.ros.diagnostics import (MIN_SHARE, WINDOW_S, Durations, EventCounter,
                                       NodeDiagnostics, Refusals, add_counter, add_durations)
from img_recog.ros.reconfigure import Reconfigurable
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.image_publisher import ImagePublisher
from img_recog.settings import setting_fields

_MIN_MEASURED_S = 0.5
# a source that the node reads at a rate; a device gives frames by itself
_LATE = 'the frames are late; a smaller image, a lower rate or fewer subscribers may help'
_DARK = 'more light, a smaller image or fewer subscribers may help'
_CHECK_PERIOD_S = 0.2
_FLUSH_S = 0.3
_NO_CLOCK = ('the time is unknown: there is no message on /clock; start the simulator, or set '
             '/use_sim_time to false and start the camera again')
# read by diagnostic_updater, by CompressedImages (a namespace), and here separately
_FOREIGN_PARAMETERS = ('diagnostic_period', 'image_raw', 'intrinsic_controls')


class CameraDiagnostics:
    """Counts frames, and reports the counts and the rate.

    frames: that were published. skipped: those that could not be used. dropped: those that were
    dropped to keep the rate. late: periods by which frames came later than the source says.
    ages: of the frames when they are captured, where the source knows it.
    publishing: how long it takes to publish a frame.
    """

    def __init__(self, device: str, now: Callable[[], float] = time.monotonic):
        self._device = device
        # what to do without frames, and after a loss
        self._advice = (('check its server and the network',) * 2 if '://' in device else
                        ('check the camera and its cable', 'connect the camera again'))
        self._source: Optional[FrameSource] = None
        self.frames, self.dropped, self.skipped = EventCounter(now), EventCounter(now), Refusals()
        self.late = EventCounter(now)
        self.ages, self.publishing = Durations(), Durations()
        self._lost: Optional[str] = None
        self._losses, self._active = 0, False

    def opened(self, source: FrameSource) -> None:
        """Store the source that was opened, and start to measure its rate."""
        self._source = source
        self.frames.restart()

    def lost(self, reason: str) -> None:
        """Report the loss of the device as an error from now on."""
        self._lost, self._losses = reason, self._losses + 1

    def reconnected(self) -> None:
        """Report the device as present again."""
        self._lost = None

    def set_active(self, active: bool) -> None:
        """Store whether the camera is capturing, not suspended; to be called again and again."""
        if active != self._active:
            self._active = active
            self.frames.restart()

    def report(self, status: DiagnosticStatusWrapper) -> None:
        """Fill in the status; to be called once in each period."""
        source, rate_hz = self._source, self._rate_hz()
        expected_hz = source.expected_hz if source else None
        if source is not None and source.max_hz and expected_hz:
            expected_hz = min(expected_hz, source.max_hz)
        status.summary(*self._summary(rate_hz, expected_hz))
        status.add('device', self._device)
        status.add('format', source.description if source else 'not open')
        status.add('frame rate (Hz)', 'unknown' if rate_hz is None else '{:.2f}'.format(rate_hz))
        status.add('expected rate (Hz)', '{:.2f}'.format(expected_hz) if expected_hz
                   else 'unknown')
        for name, count in (('frames', self.frames.total), ('failed reads', self.skipped.total),
                            ('frames dropped', self.dropped.total),
                            ('periods late', self.late.total),
                            ('losses of the device', self._losses)):
            status.add(name, str(count))
        status.add('last failed read', self.skipped.last_reason)
        add_durations(status, 'age of a frame', self.ages)
        add_durations(status, 'publishing a frame', self.publishing)
        if self.skipped.take_recent():
            status.mergeSummary(DiagnosticStatus.WARN, 'failed read: ' + self.skipped.last_reason)

    def _summary(self, rate_hz: Optional[float],
                 expected_hz: Optional[float]) -> Tuple[int, str]:
        if not self._active:
            return DiagnosticStatus.OK, 'suspended'
        lost = self._lost       # another thread may change it
        if lost is not None:
            return DiagnosticStatus.ERROR, '{}; {}'.format(lost, self._advice[1])
        if rate_hz is None:
            return DiagnosticStatus.OK, 'starting' if self._source else 'waiting for a first frame'
        if rate_hz == 0:
            return DiagnosticStatus.WARN, 'no frames: ' + self._advice[0]
        if expected_hz and rate_hz < MIN_SHARE * expected_hz:
            return DiagnosticStatus.WARN, '{:.1f} Hz instead of {:g} Hz: {}'.format(
                rate_hz, expected_hz, _LATE if self._source and self._source.rate_hz else _DARK)
        return DiagnosticStatus.OK, '{:.1f} Hz'.format(rate_hz)

    def _rate_hz(self) -> Optional[float]:
        """Return the rate, or None when there is not enough data yet."""
        expected_hz = self._source.expected_hz if self._source is not None else None
        three_periods_s = 3.0 / expected_hz if expected_hz else 0.0
        # a slow camera needs a longer window
        rate_hz = self.frames.rate_hz(max(WINDOW_S, three_periods_s))
        is_enough = self.frames.measured_s >= max(_MIN_MEASURED_S, three_periods_s)
        return rate_hz if is_enough and self._source else None


class CameraControls:
    """Sets the controls of a device each time it is opened, and each time they change."""

    def __init__(self, settings: ControlSettings, intrinsic: Mapping[str, int]):
        self._settings, self._intrinsic = settings, intrinsic
        self._path: Optional[str] = None
        self._lock = threading.Lock()
        self._logged: Set[str] = set()

    def set_device(self, path: Optional[str]) -> None:
        """Set the controls of the device at `path`, which was opened; None: it is not a device."""
        with self._lock:
            self._path = path
            if path is None:
                self._log_without_effect()
            self._apply(self._intrinsic)

    def change(self, settings: ControlSettings) -> None:
        """Apply new settings, now and each time the device is opened again."""
        with self._lock:
            changed = [field.name for field in dataclasses.fields(settings)
                       if getattr(settings, field.name) != getattr(self._settings, field.name)]
            self._settings = settings
            self._logged = {problem for problem in self._logged
                            if not any(name in problem for name in changed)}
            self._apply({})

    def _apply(self, intrinsic: Mapping[str, int]) -> None:
        if self._path is None:
            return
        try:
            device = ControlDevice(self._path)
        except OSError as error:
            self._warn('cannot set the controls of {}: {}'.format(self._path, one_line(error)))
            return
        try:
            for problem in controls.apply(device, self._settings, intrinsic):
                self._warn(problem)
        finally:
            device.close()

    def _log_without_effect(self) -> None:
        given = [field.name for field in setting_fields(ControlSettings)
                 if getattr(self._settings, field.name) != field.default]
        if given or self._intrinsic:
            self._log_once(rospy.loginfo, 'not a device: these controls have no effect: {}'.format(
                ', '.join(given + sorted(self._intrinsic))))

    def _warn(self, problem: str) -> None:
        self._log_once(rospy.logwarn, problem)

    def _log_once(self, log: Callable[..., None], line: str) -> None:
        if line not in self._logged:       # not again each time the device is reopened
            self._logged.add(line)
            log('%s', line)


class UsbCam(Listener):
    """Publishes the frames of a capture thread; a read from a device may block for seconds.

    is_blocked: whether the capture thread was still blocked when the node ended.
    """

    def __init__(self) -> None:
        self._settings = selection.resolve_auto(parameters.read(UsbCamSettings))
        self._name = redacted(self._settings.video_device)
        controls = parameters.read(ControlSettings)
        self._controls = CameraControls(
            controls, parameters.read_one('intrinsic_controls', {}, intrinsic_controls))
        parameters.warn_of_unknown(UsbCamSettings, ControlSettings, also_known=_FOREIGN_PARAMETERS,
                                   meant=SETTINGS)
        if self._settings.io_method != 'mmap':
            rospy.loginfo('io_method %s is ignored: OpenCV always uses mmap',
                          self._settings.io_method)
        self._calibration = CameraCalibration(self._settings)
        self._stamps = Stamps()
        self._warned: Set[str] = set()
        self._failure: Optional[Exception] = None
        self.is_blocked = False
        self._opened_or_ended, self._ended, self._clock = (threading.Event() for _ in range(3))
        lifecycle.on_shutdown(self._end)
        self._images = ImagePublisher('~image_raw')
        self._compressed = CompressedImages('~image_raw')
        self._infos = rospy.Publisher('~camera_info', CameraInfo, queue_size=1)
        self._reconfigurable = Reconfigurable(controls, self._controls.change)
        self._warn = ThrottledWarning()
        self._diagnostics = CameraDiagnostics(self._name)
        self._capture = Capture(self._open, self)
        self._capture.start_thread()
        NodeDiagnostics('camera', self._name, self._report)

    def spin(self) -> None:
        """Publish frames until the node is shut down; raise the error that ends it earlier."""
        named_in_crashes('usb_cam reads ' + self._name, self._spin)

    def _spin(self) -> None:
        if self._settings.create_suspended:
            rospy.loginfo('camera: suspended until %s is called',
                          rospy.resolve_name('~start_capture'))
        else:
            self._capture.start()
            # a signal that another thread takes does not end a wait without a timeout
            while not self._opened_or_ended.wait(_CHECK_PERIOD_S):
                self._diagnostics.set_active(self._capture.wanted)
        if not self._ended.is_set():
            self._calibration.serve()
            rospy.Service('~start_capture', Empty, self._start_capture)
            rospy.Service('~stop_capture', Empty, self._stop_capture)
        try:
            while not self._ended.wait(_CHECK_PERIOD_S):
                self._capture.check()
                self._diagnostics.set_active(self._capture.wanted)
        finally:
            self.is_blocked = not self._capture.shut_down()
        if self._failure is not None:
            raise self._failure

    def _open(self) -> FrameSource:
        source = selection.open_source(self._settings, files.user_folders(), self._warn_once)
        self._controls.set_device(getattr(source, 'path', None))
        return source

    def _warn_once(self, line: str) -> None:
        if line not in self._warned:        # not again each time the source is opened again
            self._warned.add(line)
            rospy.logwarn('%s', line)

    def opened(self, source: FrameSource) -> None:
        log = rospy.logwarn if source.differs else rospy.loginfo
        log('camera: %s', source.description)
        self._calibration.set_image_size(source.width, source.height)
        self._diagnostics.opened(source)
        self._opened_or_ended.set()
        if self._is_clock_missing():
            self._wait_for_clock()

    def _is_clock_missing(self) -> bool:
        return not (self._clock.is_set() or rospy.rostime.is_wallclock())

    def _wait_for_clock(self) -> None:
        """Wait for the first message on /clock: before it, the stamps of all images are 0."""
        clock = rospy.Subscriber('/clock', Clock, lambda _: self._clock.set(), queue_size=1)
        while not self._clock.wait(_CHECK_PERIOD_S) and not self._ended.is_set():
            pass
        clock.unregister()

    def resized(self, source: FrameSource) -> None:
        self._warn('camera: from here on, %s is %dx%d: the images have this size, too',
                   source.name, source.width, source.height)
        self._calibration.set_image_size(source.width, source.height)

    def frame(self, source: FrameSource, image: np.ndarray) -> None:
        begin_s = time.perf_counter()
        if source.age_s:
            self._diagnostics.ages.add(source.age_s)
        # the age is measured by the wall clock, and cannot be subtracted from simulated time
        age_s = source.age_s if rospy.rostime.is_wallclock() else 0.0
        stamp_ns = self._stamps.stamp_ns(rospy.Time.now().to_nsec(), age_s)
        header = Header(stamp=rospy.Time(nsecs=stamp_ns), frame_id=self._settings.camera_frame_id)
        self._images.publish(image, source.encoding, header)
        self._compressed.publish(image, source.encoding, header)
        self._infos.publish(self._calibration.to_msg(header))
        self._diagnostics.frames.add()
        self._diagnostics.publishing.add(time.perf_counter() - begin_s)

    def skipped(self, reason: str) -> None:
        self._diagnostics.skipped.add(reason)
        self._warn('frame skipped: %s', reason)

    def dropped(self) -> None:
        self._diagnostics.dropped.add()

    def late(self, periods: int) -> None:
        self._diagnostics.late.add(periods)

    def lost(self, reason: str) -> None:
        self._diagnostics.lost(reason)
        rospy.logerr('camera lost: %s; waiting until it is back', reason)

    def reconnected(self) -> None:
        self._diagnostics.reconnected()
        rospy.loginfo('camera is back: %s', self._name)

    def ended(self, reason: str) -> None:
        rospy.loginfo('%s', reason)
        time.sleep(_FLUSH_S)        # other threads still send the last frame
        self._end()

    def failed(self, error: Exception, opening: bool) -> None:
        if self._ended.is_set():        # a failure during a shutdown is not why the node ends
            return
        was_open = self._opened_or_ended.is_set()
        if opening and (was_open or self._settings.create_suspended):
            # ~start_capture can be called again; only a failure at startup ends the node
            rospy.logerr('%s; still %s', error, 'stopped' if was_open else 'suspended')
            return
        self._failure = error
        self._end()

    def _end(self) -> None:
        self._ended.set()
        self._opened_or_ended.set()

    def _report(self, status: DiagnosticStatusWrapper) -> None:
        self._diagnostics.report(status)
        if self._is_clock_missing():
            status.summary(DiagnosticStatus.WARN, _NO_CLOCK)
        add_counter(status, 'compressed images', self._compressed.sent)
        status.add('frames not compressed', str(self._compressed.dropped.total))

    def _start_capture(self, _: EmptyRequest) -> EmptyResponse:
        self._capture.start()
        return EmptyResponse()

    def _stop_capture(self, _: EmptyRequest) -> EmptyResponse:
        self._capture.stop()
        return EmptyResponse()


def main() -> int:
    """Run the node; return its exit code."""
    nodes: List[UsbCam] = []

    def serve() -> None:
        nodes.append(UsbCam())
        nodes[0].spin()
    code = lifecycle.run('usb_cam', serve, {
        '~': (UsbCamSettings, ControlSettings),
        '~image_raw/compressed/': (CompressionSettings,)})
    if nodes and nodes[0].is_blocked:
        lifecycle.leave_blocked_threads(code)
    return code
