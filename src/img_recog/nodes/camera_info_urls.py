"""Calibration URLs, as camera_info_manager reads them, to paths."""
import os

import rospkg

from img_recog.errors import UserError


class UrlError(UserError):
    """A camera_info_url cannot be turned into a path."""


def path_of(url: str, camera_name: str) -> str:
    """Return the path that a calibration URL stands for.

    url: file:///PATH, package://PACKAGE/PATH, or empty for camera_info/CAMERA_NAME.yaml in
    ROS_HOME; ${NAME} is replaced by the camera's name and ${ROS_HOME} by that folder.
    Raises UrlError for another scheme or an unknown package.
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
            raise UrlError('parameter camera_info_url: got {!r}, but there is no package {}'
                           .format(url, package))
    raise UrlError('parameter camera_info_url: got {!r}, allowed is file:///PATH, '
                   'package://PACKAGE/PATH or empty'.format(url))
