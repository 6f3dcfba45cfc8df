"""Finds files of ROS packages and Gazebo models by URI, and this package's robot and worlds."""
import itertools
import os
from typing import Dict, Iterable, Iterator, Optional

import rospkg

from img_recog.files import user_folders

DEFAULT_WORLD = 'turtlebot3_world'
_PACKAGE = 'package://'
_MODEL = 'model://'
_FILE = 'file://'
_DOWNLOADED = os.path.join('~', '.gazebo', 'models')
_GAZEBO_WORLDS = 'turtlebot3_gazebo'
_packages = rospkg.RosPack()


def find(uri: str) -> Optional[str]:
    """Return the path of what is at a package://, model:// or file:// URI or a path, else None.

    As in Gazebo, model:// is searched for in the folders of GAZEBO_MODEL_PATH, in those that
    packages export to gazebo_ros as gazebo_model_path, and in that for which Gazebo downloads
    them; a relative path, with file:// or without, in the working directory, in the folders of
    GAZEBO_RESOURCE_PATH, and in those that packages export as gazebo_media_path. Except for
    package:// it can be a folder.
    """
    exists = os.path.exists
    if uri.startswith(_PACKAGE):
        package, _, path = uri[len(_PACKAGE):].partition('/')
        try:
            folders: Iterable[str] = [_packages.get_path(package)]
        except rospkg.ResourceNotFound:
            return None
        exists = os.path.isfile
    elif uri.startswith(_MODEL):
        path = uri[len(_MODEL):].lstrip('/')
        folders = itertools.chain(_gazebo_folders('GAZEBO_MODEL_PATH', 'gazebo_model_path'),
                                  [os.path.expanduser(_DOWNLOADED)])
    else:
        path = uri[len(_FILE):] if uri.startswith(_FILE) else uri
        folders = itertools.chain(user_folders(), _gazebo_folders('GAZEBO_RESOURCE_PATH',
                                                                  'gazebo_media_path'))
        if '://' in path or not path:
            return None
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


def _gazebo_folders(variable: str, export: str) -> Iterator[str]:
    """Return the folders in a variable of the environment, and those that packages export."""
    yield from os.environ.get(variable, '').split(os.pathsep)
    for package in _packages.list():
        try:
            exports = _packages.get_manifest(package).get_export('gazebo_ros', export)
        except Exception:       # a package.xml that is not valid raises errors of several types
            continue
        for folder in exports:
            yield folder.replace('${prefix}', _packages.get_path(package))


def _own_file(name: str, folder: str = 'urdf') -> str:
    return os.path.join(rospkg.RosPack().get_path('img_recog'), folder, name)
