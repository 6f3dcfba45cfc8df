"""Calibration URLs, as camera_info_manager reads them, to paths."""
import os

import rospkg

from img_recog.settings import SettingError

_ALLOWED = 'file:///PATH, package://PACKAGE/PATH or empty'


def path_of(url: str, camera_name: str) -> str:
    """Return the path that a calibration URL stands for.

    url: file:///PATH, package://PACKAGE/PATH, or empty for camera_info/CAMERA_NAME.yaml in
    ROS_HOME; ${NAME} is replaced by the camera's name and ${ROS_HOME} by that folder.
    Raises SettingError for another scheme or an unknown package.
    """
    url = url or 'file://${ROS_HOME}/camera_info/${NAME}.yaml'
    resolved = url.replace('${NAME}', camera_name).replace('${ROS_HOME}', rospkg.get_ros_home())
    scheme, _, rest = resolved.partition('://')
    if scheme == 'file' and rest.startswith('/'):
        return rest
    if scheme == 'package' and '/' in rest:
        package, _, path = rest.partition('/')
        try:
            return os.path.join(rospkg.RosPack().get_path(package), path)
        except rospkg.ResourceNotFound:
            raise SettingError('camera_info_url', url, '{} (there is no package {})'.format(
                _ALLOWED, package))
    raise SettingError('camera_info_url', url, _ALLOWED)
