"""The materials of mesh files, and where their textures are."""
import os
import re
from typing import Any, List, Sequence
from urllib.parse import unquote

from img_recog.model import Material

# where Gazebo looks for the textures of a mesh
_FOLDERS = ('', os.path.join('..', 'materials', 'textures'))
_FILE = 'file://'
_SEPARATOR = re.compile(r'[/\\]')        # of paths, also of other systems
# of a model or package, whose folder is above that of the mesh or beside one that is
_IN_FOLDER = re.compile('(?:model|package)://')
_BASE = 200         # of the numbers that colors stand for


# of a COLLADA file that says nothing of its colors, as in Gazebo
UNSTATED_AMBIENT = (0.4, 0.4, 0.4)
UNSTATED = Material((0.5, 0.5, 0.5, 1.0), ambient=UNSTATED_AMBIENT)


def number_color(number: int) -> List[float]:
    """Return a color, of 0 to 1, that stands for a number below 200^3.

    trimesh gets it in place of a material, of which it would drop what it does not know.

    >>> number_of([int(255 * value) for value in number_color(70000)])
    70000
    """
    # the same number whether the color is rounded to 1/255 or cut off
    return [(number // power % _BASE + 0.25) / 255 for power in (_BASE ** 2, _BASE, 1)]


def number_of(color: Sequence[Any]) -> int:
    """Return the number that a color of 0 to 255 stands for."""
    red, green, blue = (int(value) for value in color[:3])
    return (red * _BASE + green) * _BASE + blue


def find_texture(mesh: str, name: str) -> str:
    """Return the path of a texture that a mesh file names, found as Gazebo finds it.

    One that is not there is also searched for where the mesh is, without the folders of its name,
    and in all folders above. Without any it is the path where it should be, '' for no name.
    """
    given = unquote(name.strip())
    if not given:
        return ''
    folder = os.path.dirname(os.path.abspath(mesh))
    in_folder = _IN_FOLDER.match(given)
    given = given[len(_FILE):] if given.startswith(_FILE) else given
    beside = [os.path.join(folder, each) for each in _FOLDERS]
    paths = [] if in_folder else [os.path.join(each, given) for each in beside]
    words = _SEPARATOR.split(given[in_folder.end():] if in_folder else given)
    below = [word for word in words if word not in ('', '..')]
    paths += [os.path.join(each, *below) for each in _above(folder)]
    paths += [os.path.join(each, words[-1]) for each in beside]
    return os.path.normpath(next((path for path in paths if os.path.isfile(path)), paths[0]))


def _above(folder: str) -> List[str]:
    """Return the folders that contain a folder, the nearest first."""
    found = []
    while folder != os.path.dirname(folder):
        folder = os.path.dirname(folder)
        found.append(folder)
    return found
