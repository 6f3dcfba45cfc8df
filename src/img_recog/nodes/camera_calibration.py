"""The calibration of a camera: its file, its service and its message."""
from typing import Optional, Tuple

import rospy
from sensor_msgs.msg import CameraInfo
from sensor_msgs.srv import SetCameraInfo, SetCameraInfoResponse
from std_msgs.msg import Header

from img_recog.camera import calibration
from img_recog.camera.calibration import Calibration
from img_recog.camera.settings import CameraSettings
from img_recog.nodes import camera_info_msgs, camera_info_urls


class CameraCalibration:
    """Knows the calibration in force; serves ~set_camera_info (sensor_msgs/SetCameraInfo)."""

    def __init__(self, settings: CameraSettings):
        """Load the calibration file, if there is one.

        Raises UrlError when camera_info_url names no file.
        """
        self._name = settings.camera_name
        self._path = camera_info_urls.path_of(settings.camera_info_url, settings.camera_name)
        self._loaded = _load(self._path)
        self._in_force: Optional[Calibration] = None
        self._size: Optional[Tuple[int, int]] = None

    def serve(self) -> None:
        """Advertise the service."""
        rospy.Service('~set_camera_info', SetCameraInfo, self._set_camera_info)

    def images_are(self, width: int, height: int) -> None:
        """Fit the calibration to images of this size, in pixels."""
        if self._size == (width, height):
            return
        self._size, self._in_force = (width, height), None
        if self._loaded is None:
            return
        try:
            self._in_force = calibration.scaled(self._loaded, width, height)
        except calibration.CalibrationError as error:
            rospy.logwarn('%s: %s: publishing none', self._path, error)
            return
        if self._in_force is not self._loaded:
            rospy.loginfo('calibration %s is for %dx%d: scaled to %dx%d', self._path,
                          self._loaded.width, self._loaded.height, width, height)

    def to_msg(self, header: Header) -> CameraInfo:
        """Return the message for images of the size given last."""
        return camera_info_msgs.to_msg(self._in_force, *self._size, header)

    def _set_camera_info(self, request) -> SetCameraInfoResponse:
        given = camera_info_msgs.from_msg(request.camera_info, self._name)
        if self._size is not None and (given.width, given.height) != self._size:
            return SetCameraInfoResponse(success=False, status_message=(
                'the calibration is for {}x{}, the images are {}x{}'.format(
                    given.width, given.height, *self._size)))
        try:
            calibration.save(self._path, given)
        except calibration.CalibrationError as error:
            rospy.logerr('%s', error)
            return SetCameraInfoResponse(success=False, status_message=str(error))
        self._loaded = self._in_force = given
        rospy.loginfo('calibration written to %s', self._path)
        return SetCameraInfoResponse(success=True, status_message=self._path)


def _load(path: str) -> Optional[Calibration]:
    try:
        return calibration.load(path)
    except FileNotFoundError:
        rospy.loginfo('camera is not calibrated: no %s', path)
    except calibration.CalibrationError as error:
        rospy.logerr('%s; publishing no calibration', error)
    return None
