"""The node usb_cam: frames of a camera, a film, a still image or the synthetic scene.

Publishes, for every frame and with one header: ~image_raw (sensor_msgs/Image, rgb8, or mono8 for
grey pixel formats of a device) and ~camera_info (sensor_msgs/CameraInfo), at the rate of the
source. Subscribes to nothing. Serves: ~start_capture, ~stop_capture (std_srvs/Empty),
~set_camera_info (sensor_msgs/SetCameraInfo). Reads: the fields of CameraSettings as private
parameters.
"""
import threading
from typing import Optional

import rospy
from sensor_msgs.msg import CameraInfo, Image
from sensor_msgs.srv import SetCameraInfo, SetCameraInfoResponse
from std_msgs.msg import Header
from std_srvs.srv import Empty, EmptyResponse

from img_recog.camera import calibration
from img_recog.camera.calibration import Calibration
from img_recog.camera.pacing import Pacer
from img_recog.camera.selection import open_source
from img_recog.camera.settings import CameraSettings
from img_recog.camera.source import FrameSource
from img_recog.nodes import (camera_info_msgs, camera_info_urls, image_msgs, parameters, running,
                             user_paths)

_CLOSING_S = 1.0


class UsbCam:
    """Publishes frames from a thread of its own, since reading a device may block for seconds."""

    def __init__(self):
        self._settings = parameters.read(CameraSettings)
        parameters.warn_of_unknown(CameraSettings)
        self._calibration_path = camera_info_urls.path_of(self._settings.camera_info_url,
                                                          self._settings.camera_name)
        self._calibration = _load_calibration(self._calibration_path)
        self._failure = None
        self._wanted, self._ended = threading.Event(), threading.Event()
        self._wanted.set()
        rospy.on_shutdown(self._ended.set)
        self._images = rospy.Publisher('~image_raw', Image, queue_size=1)
        self._infos = rospy.Publisher('~camera_info', CameraInfo, queue_size=1)
        self._source = self._open()
        rospy.Service('~start_capture', Empty, self._start)
        rospy.Service('~stop_capture', Empty, self._stop)
        rospy.Service('~set_camera_info', SetCameraInfo, self._set_camera_info)

    def spin(self) -> None:
        """Publish frames until the node is shut down; raise the error that ends them earlier."""
        capture = threading.Thread(target=self._capture, daemon=True)
        capture.start()
        self._ended.wait()
        # time to give the device back, but no more: a read may block for seconds
        capture.join(_CLOSING_S)
        if self._failure is not None:
            raise self._failure

    def _open(self) -> FrameSource:
        source = open_source(self._settings, user_paths.folders())
        rospy.loginfo('camera: %s', source.description)
        self._size = (source.width, source.height)
        self._check_calibration(source)
        return source

    def _capture(self) -> None:
        try:
            while not self._ended.is_set():
                if self._wanted.wait(0.1):
                    self._publish_until_stopped()
        except Exception as error:      # whatever it is, spin raises it in the main thread
            self._failure = error
            self._ended.set()

    def _publish_until_stopped(self) -> None:
        source, self._source = self._source or self._open(), None
        pacer = Pacer(source.rate_hz) if source.rate_hz else None
        try:
            while self._wanted.is_set() and not self._ended.is_set():
                image = source.read()
                if pacer is not None and self._ended.wait(pacer.delay_s()):
                    return
                self._publish(source, image)
        finally:
            source.close()

    def _publish(self, source: FrameSource, image) -> None:
        header = Header(stamp=rospy.Time.now(), frame_id=self._settings.camera_frame_id)
        self._images.publish(image_msgs.to_msg(image, source.encoding, header))
        self._infos.publish(camera_info_msgs.to_msg(
            self._calibration, source.width, source.height, header))

    def _start(self, _) -> EmptyResponse:
        self._wanted.set()
        return EmptyResponse()

    def _stop(self, _) -> EmptyResponse:
        self._wanted.clear()
        return EmptyResponse()

    def _set_camera_info(self, request) -> SetCameraInfoResponse:
        given = camera_info_msgs.from_msg(request.camera_info, self._settings.camera_name)
        if (given.width, given.height) != self._size:
            return SetCameraInfoResponse(success=False, status_message=(
                'the calibration is for {}x{}, the images are {}x{}'.format(
                    given.width, given.height, *self._size)))
        try:
            calibration.save(self._calibration_path, given)
        except calibration.CalibrationError as error:
            rospy.logerr('%s', error)
            return SetCameraInfoResponse(success=False, status_message=str(error))
        self._calibration = given
        rospy.loginfo('calibration written to %s', self._calibration_path)
        return SetCameraInfoResponse(success=True, status_message=self._calibration_path)

    def _check_calibration(self, source: FrameSource) -> None:
        known = self._calibration
        if known is not None and (known.width, known.height) != (source.width, source.height):
            rospy.logwarn('calibration %s is for %dx%d, the images are %dx%d: publishing none',
                          self._calibration_path, known.width, known.height, source.width,
                          source.height)
            self._calibration = None


def _load_calibration(path: str) -> Optional[Calibration]:
    try:
        return calibration.load(path)
    except FileNotFoundError:
        rospy.loginfo('camera is not calibrated: no %s', path)
    except calibration.CalibrationError as error:
        rospy.logerr('%s; publishing no calibration', error)
    return None


def main() -> int:
    """Run the node; return its exit code."""
    return running.run('usb_cam', lambda: UsbCam().spin())
