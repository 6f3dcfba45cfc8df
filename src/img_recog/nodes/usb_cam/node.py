"""The node usb_cam: frames of a camera, a video, images, a stream or the synthetic scene.

Publishes, for every frame and with one header: ~image_raw (sensor_msgs/Image, rgb8, or mono8 for
grey pixel formats of a device), while somebody subscribes ~image_raw/compressed
(sensor_msgs/CompressedImage), and ~camera_info (sensor_msgs/CameraInfo), at the rate of the
source, in the frame camera_frame_id; /diagnostics (diagnostic_msgs/DiagnosticArray) at 1 Hz;
~parameter_descriptions and ~parameter_updates (dynamic_reconfigure) here and in
~image_raw/compressed.
Subscribes to nothing. Serves: ~start_capture, ~stop_capture (std_srvs/Empty), ~set_camera_info
(sensor_msgs/SetCameraInfo), ~set_parameters (dynamic_reconfigure). Reads: the fields of
CameraSettings and ControlSettings and intrinsic_controls as private parameters, those of
CompressionSettings in ~image_raw/compressed.
"""
import threading
import time
from typing import Optional

import numpy as np
import rospy
from sensor_msgs.msg import CameraInfo
from std_msgs.msg import Header
from std_srvs.srv import Empty, EmptyResponse

from img_recog import files
from img_recog.camera import selection, urls
from img_recog.camera.capture import Capture, Listener
from img_recog.camera.settings import CameraSettings, ControlSettings, intrinsic_controls
from img_recog.camera.source import FrameSource
from img_recog.camera.stamps import Stamps
from img_recog.nodes.usb_cam.calibration import CameraCalibration
from img_recog.nodes.usb_cam.compressed_publisher import CompressedImages
from img_recog.nodes.usb_cam.controls import CameraControls
from img_recog.nodes.usb_cam.diagnostics import CameraDiagnostics
from img_recog.ros import lifecycle, parameters
from img_recog.ros.reconfigure import Reconfigurable
from img_recog.ros.throttle import ThrottledWarning
from img_recog.ros.transport.image_publisher import ImagePublisher

_CHECK_S = 0.2
_FLUSH_S = 0.3
# of others: dynamic_reconfigure's and image_transport's namespaces, diagnostic_updater's own
_FOREIGN_PARAMETERS = ('diagnostic_period', 'image_raw', 'intrinsic_controls')


class UsbCam(Listener):
    """Publishes what a capture thread gives; reading a device may block for seconds.

    is_blocked: whether the thread was blocked when the node ended, and still is for all we know.
    """

    def __init__(self):
        self._settings = selection.resolve_auto(parameters.read(CameraSettings))
        self._name = urls.redacted(self._settings.video_device)
        controls = parameters.read(ControlSettings)
        self._controls = CameraControls(
            controls, parameters.read_one('intrinsic_controls', {}, intrinsic_controls))
        parameters.warn_of_unknown(CameraSettings, ControlSettings, also_known=_FOREIGN_PARAMETERS)
        if self._settings.io_method != 'mmap':
            rospy.loginfo('io_method %s: OpenCV always maps the memory of a device, as mmap does',
                          self._settings.io_method)
        self._calibration = CameraCalibration(self._settings)
        self._stamps = Stamps()
        self._failure: Optional[Exception] = None
        self._opened_once = False
        self.is_blocked = False
        self._settled, self._ended = threading.Event(), threading.Event()
        lifecycle.on_shutdown(self._end)
        self._images = ImagePublisher('~image_raw')
        self._compressed = CompressedImages('~image_raw')
        self._infos = rospy.Publisher('~camera_info', CameraInfo, queue_size=1)
        self._reconfigurable = Reconfigurable(controls, self._controls.change)
        self._warn = ThrottledWarning()
        self._diagnostics = CameraDiagnostics(self._name)
        self._capture = Capture(self._open, self)
        self._capture.begin()

    def spin(self) -> None:
        """Publish frames until the node is shut down; raise the error that ends them earlier."""
        if self._settings.create_suspended:
            rospy.loginfo('camera: suspended until %s is called',
                          rospy.resolve_name('~start_capture'))
        else:
            self._capture.start()
            self._settled.wait()
        if not self._ended.is_set():
            self._calibration.serve()
            rospy.Service('~start_capture', Empty, self._start)
            rospy.Service('~stop_capture', Empty, self._stop)
        try:
            while not self._ended.wait(_CHECK_S):
                self._capture.check()
                self._diagnostics.update(self._capture.wanted)
        finally:
            self.is_blocked = not self._capture.shut_down()
        if self._failure is not None:
            raise self._failure

    def _open(self) -> FrameSource:
        source = selection.open_source(self._settings, files.user_folders(), rospy.logwarn)
        self._controls.set_device(getattr(source, 'path', None))
        return source

    def opened(self, source: FrameSource) -> None:
        log = rospy.logwarn if source.differs else rospy.loginfo
        log('camera: %s', source.description)
        self._opened_once = True
        self._calibration.set_image_size(source.width, source.height)
        self._diagnostics.opened(source)
        self._settled.set()

    def frame(self, source: FrameSource, image: np.ndarray) -> None:
        # the age is by the wall's clock, and means nothing to a simulated one
        age_s = source.age_s if rospy.rostime.is_wallclock() else 0.0
        stamp_ns = self._stamps.stamp_ns(rospy.Time.now().to_nsec(), age_s)
        header = Header(stamp=rospy.Time(nsecs=stamp_ns), frame_id=self._settings.camera_frame_id)
        self._images.publish(image, source.encoding, header)
        self._compressed.publish(image, source.encoding, header)
        self._infos.publish(self._calibration.to_msg(header))
        self._diagnostics.count_frame()

    def skipped(self, reason: str) -> None:
        self._diagnostics.count_skipped()
        self._warn('frame skipped: %s', reason)

    def dropped(self) -> None:
        self._diagnostics.count_dropped()

    def lost(self, reason: str) -> None:
        self._diagnostics.lost(reason)
        rospy.logerr('camera lost: %s; waiting for it to come back', reason)

    def reconnected(self) -> None:
        self._diagnostics.reconnected()
        rospy.loginfo('camera is back: %s', self._name)

    def ended(self, reason: str) -> None:
        rospy.loginfo('%s', reason)
        time.sleep(_FLUSH_S)        # the publishers send the last frame from threads of their own
        self._end()

    def failed(self, error: Exception, opening: bool) -> None:
        if opening and (self._opened_once or self._settings.create_suspended):
            # by ~start_capture, which can be called again; the start of the node is not
            rospy.logerr('%s; still %s', error, 'stopped' if self._opened_once else 'suspended')
            return
        self._failure = error
        self._end()

    def _end(self) -> None:
        self._ended.set()
        self._settled.set()

    def _start(self, _) -> EmptyResponse:
        self._capture.start()
        return EmptyResponse()

    def _stop(self, _) -> EmptyResponse:
        self._capture.stop()
        return EmptyResponse()


def main() -> int:
    """Run the node; return its exit code."""
    nodes = []

    def serve():
        nodes.append(UsbCam())
        nodes[0].spin()
    code = lifecycle.run('usb_cam', serve)
    if nodes and nodes[0].is_blocked:
        lifecycle.leave_blocked_threads(code)
    return code
