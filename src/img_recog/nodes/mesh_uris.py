"""URIs of meshes, as robot descriptions and worlds have them."""
import os
from typing import Optional

import rospkg

from img_recog.simulation.meshes import find_file

_PACKAGE = 'package://'
_MODEL = 'model://'
_packages = rospkg.RosPack()


def find(uri: str) -> Optional[str]:
    """Return the path of the file that package://, model://, file:// or a path means, else None.

    Models are looked for in the folders of GAZEBO_MODEL_PATH.
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
        return find_file(os.getcwd())(uri)
    paths = (os.path.join(folder, path) for folder in folders if folder)
    return next(filter(os.path.isfile, paths), None)
