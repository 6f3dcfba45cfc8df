"""The calibration of the camera: its file, its service and its message."""
import os
import reprlib
from typing import Optional, Tuple

import rospkg
import rospy
from sensor_msgs.msg import CameraInfo
from sensor_msgs.srv import SetCameraInfo, SetCameraInfoRequest, SetCameraInfoResponse
from std_msgs.msg import Header

from img_recog import files
from img_recog.camera import calibration
from img_recog.camera.calibration import Calibration
from img_recog.camera.usb_cam_settings import UsbCamSettings
from img_recog.conversions import image_msgs
from img_recog.ros import parameters
from img_recog.settings import SettingError

_URLS = 'file:///PATH, package://PACKAGE/PATH or empty'


class CameraCalibration:
    """The current calibration, and the service ~set_camera_info (sensor_msgs/SetCameraInfo)."""

    def __init__(self, settings: UsbCamSettings):
        """Load the calibration file if it exists.

        Raises ParameterError when camera_info_url is not the URL of a file.
        """
        self._name = settings.camera_name
        self._path = parameters.read_one(
            'camera_info_url', '', lambda url: path_of_url(url, self._name))
        removed = files.remove_leftovers([self._path])
        if removed:
            rospy.logwarn('%s', removed)
        self._loaded = _load(self._path, self._name)
        # for the current image size; None when it is not calibrated
        self._current: Optional[Calibration] = None
        # of the images, in pixels; None before the first one
        self._size: Optional[Tuple[int, int]] = None
        # the size that the images will have, where it is known before the first one
        self._expected_size = ((settings.image_width, settings.image_height)
                               if settings.video_device == 'synthetic' else None)

    def serve(self) -> None:
        """Advertise the service."""
        rospy.Service('~set_camera_info', SetCameraInfo, self._set_camera_info)

    def set_image_size(self, width: int, height: int) -> None:
        """Scale the calibration to images of this size, in pixels."""
        if self._size == (width, height):
            return
        self._size, self._current = (width, height), None
        if self._loaded is None:
            return
        try:
            self._current = calibration.scaled(self._loaded, width, height)
        except calibration.CalibrationError as error:
            rospy.logwarn('%s: %s; publishing no calibration', self._path, error)
            return
        if self._current is not self._loaded:
            rospy.loginfo('calibration %s is for %dx%d: scaled to %dx%d', self._path,
                          self._loaded.width, self._loaded.height, width, height)

    def to_msg(self, header: Header) -> CameraInfo:
        """Return the message for images of the current size; call `set_image_size` first."""
        width, height = self._size or (0, 0)
        return image_msgs.info_to_msg(self._current, width, height, header)

    def _set_camera_info(self, request: SetCameraInfoRequest) -> SetCameraInfoResponse:
        given = image_msgs.info_from_msg(request.camera_info, self._name)
        size = self._size or self._expected_size
        try:
            calibration.check(given)
            if size is not None and (given.width, given.height) != size:
                raise calibration.CalibrationError(
                    'the calibration is for {}x{}, the images are {}x{}'.format(
                        given.width, given.height, *size))
            calibration.save(self._path, given)
        except calibration.CalibrationError as error:
            rospy.logerr('set_camera_info: %s', error)
            return SetCameraInfoResponse(success=False, status_message=str(error))
        self._loaded = given
        if self._size is not None:
            self._current = given
        rospy.loginfo('calibration written to %s', self._path)
        unchecked = '' if size else ('; its size {}x{} could not be checked: the camera has not '
                                     'been opened yet'.format(given.width, given.height))
        return SetCameraInfoResponse(success=True, status_message=self._path + unchecked)


def path_of_url(url: str, camera_name: str) -> str:
    """Return the path of a calibration URL.

    url: file:///PATH, package://PACKAGE/PATH, or empty for camera_info/CAMERA_NAME.yaml in
    ROS_HOME; a relative PATH of file:// starts in the user's folder. ${NAME} is replaced by the
    name of the camera and ${ROS_HOME} by that folder.
    Raises SettingError for another scheme, an .ini file, an unknown package or a path outside of
    it.
    """
    url = url or 'file://${ROS_HOME}/camera_info/${NAME}.yaml'
    resolved = url.replace('${ROS_HOME}', rospkg.get_ros_home()).replace('${NAME}', camera_name)
    if resolved.lower().endswith('.ini'):
        raise SettingError('camera_info_url', url, 'the URL of a YAML file; make one by "rosrun '
                           'camera_calibration_parsers convert OLD.ini NEW.yaml"')
    scheme, _, rest = resolved.partition('://')
    if scheme == 'file' and rest:
        return files.user_output_path(rest)
    if scheme == 'package' and '/' in rest:
        package, _, path = rest.partition('/')
        try:
            folder = rospkg.RosPack().get_path(package)
        except rospkg.ResourceNotFound:
            raise SettingError('camera_info_url', url, '{} (there is no package {})'.format(
                _URLS, package))
        resolved = os.path.normpath(os.path.join(folder, path))
        if not resolved.startswith(os.path.join(os.path.normpath(folder), '')):
            raise SettingError('camera_info_url', url,
                               '{} (the path leaves the package {})'.format(_URLS, package))
        return resolved
    raise SettingError('camera_info_url', url, _URLS)


def _load(path: str, camera_name: str) -> Optional[Calibration]:
    try:
        loaded = calibration.load(path, rospy.logwarn)
    except FileNotFoundError:
        rospy.loginfo('camera is not calibrated: there is no file %s', path)
        return None
    except calibration.CalibrationError as error:
        rospy.logerr('%s; publishing no calibration', error)
        return None
    if loaded.camera_name not in ('', camera_name):
        rospy.logwarn('calibration %s is for camera %s, but camera_name is %s; using it anyway',
                      path, reprlib.repr(loaded.camera_name), camera_name)
    return loaded
