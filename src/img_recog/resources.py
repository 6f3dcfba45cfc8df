"""Finds files of ROS packages and Gazebo models by URI, and this package's robot and worlds."""
import os
from typing import Dict, Optional

import rospkg

from img_recog.files import find_in

DEFAULT_WORLD = 'turtlebot3_world'
_PACKAGE = 'package://'
_MODEL = 'model://'
_packages = rospkg.RosPack()


def find(uri: str) -> Optional[str]:
    """Return the path of the file at a package://, model:// or file:// URI or a path, else None.

    model:// is searched in the folders of GAZEBO_MODEL_PATH.
    """
    if uri.startswith(_PACKAGE):
        package, _, path = uri[len(_PACKAGE):].partition('/')
        try:
            folders = [_packages.get_path(package)]
        except rospkg.ResourceNotFound:
            return None
    elif uri.startswith(_MODEL):
        path = uri[len(_MODEL):]
        folders = os.environ.get('GAZEBO_MODEL_PATH', '').split(os.pathsep)
    else:
        return find_in(os.getcwd())(uri)
    paths = (os.path.join(folder, path) for folder in folders if folder)
    return next((path for path in paths if os.path.isfile(path)), None)


def worlds() -> Dict[str, str]:
    """Return the names of the worlds of this package, and the paths of their files."""
    return {DEFAULT_WORLD: _own_file('turtlebot3_world.urdf')}


def burger() -> str:
    """Return the path of the burger's URDF."""
    return _own_file('turtlebot3_burger.urdf')


def _own_file(name: str) -> str:
    return os.path.join(rospkg.RosPack().get_path('img_recog'), 'urdf', name)
