"""Finds files of ROS packages and Gazebo models by URI, and this package's robot and worlds."""
import itertools
import os
from typing import Dict, Iterable, Iterator, Optional

import rospkg

from img_recog.files import find_in

DEFAULT_WORLD = 'turtlebot3_world'
_PACKAGE = 'package://'
_MODEL = 'model://'
_GAZEBO_WORLDS = 'turtlebot3_gazebo'
_packages = rospkg.RosPack()


def find(uri: str) -> Optional[str]:
    """Return the path of what is at a package://, model:// or file:// URI or a path, else None.

    model:// is searched for in the folders of GAZEBO_MODEL_PATH, and then in those that packages
    export as gazebo_model_path; it can be a folder.
    """
    folders: Iterable[str]
    if uri.startswith(_PACKAGE):
        package, _, path = uri[len(_PACKAGE):].partition('/')
        try:
            folders = [_packages.get_path(package)]
        except rospkg.ResourceNotFound:
            return None
    elif uri.startswith(_MODEL):
        path = uri[len(_MODEL):].lstrip('/')
        folders = itertools.chain(os.environ.get('GAZEBO_MODEL_PATH', '').split(os.pathsep),
                                  _exported_folders())
    else:
        return find_in(os.getcwd())(uri)
    exists = os.path.exists if uri.startswith(_MODEL) else os.path.isfile
    paths = (os.path.join(folder, path) for folder in folders if folder)
    return next((path for path in paths if exists(path)), None)


def worlds() -> Dict[str, str]:
    """Return the names of worlds, and the paths of their files.

    They are those of this package, and those of turtlebot3_gazebo if it is found.
    """
    found: Dict[str, str] = {}
    try:
        folder = os.path.join(_packages.get_path(_GAZEBO_WORLDS), 'worlds')
        found = {os.path.splitext(name)[0]: os.path.join(folder, name)
                 for name in os.listdir(folder) if name.endswith('.world')}
    except (rospkg.ResourceNotFound, OSError):
        pass
    return {**found, DEFAULT_WORLD: _own_file('turtlebot3_world.urdf'),
            'color_posts': _own_file('color_posts.sdf')}


def burger() -> str:
    """Return the path of the burger's URDF."""
    return _own_file('turtlebot3_burger.urdf')


def colors() -> str:
    """Return the path of the file with the colors of the article."""
    return _own_file('colors.yaml', 'config')


def _exported_folders() -> Iterator[str]:
    """Return the folders of models that packages export to gazebo_ros."""
    for package in _packages.list():
        try:
            exports = _packages.get_manifest(package).get_export('gazebo_ros', 'gazebo_model_path')
        except Exception:       # a package.xml that is not valid raises errors of several types
            continue
        for folder in exports:
            yield folder.replace('${prefix}', _packages.get_path(package))


def _own_file(name: str, folder: str = 'urdf') -> str:
    return os.path.join(rospkg.RosPack().get_path('img_recog'), folder, name)
