"""The worlds and the robot that this package brings along."""
import os

import rospkg

from img_recog.nodes import mesh_uris, user_paths
from img_recog.simulation import world_file

DEFAULT_WORLD = 'turtlebot3_world'


def read(world: str) -> world_file.WorldFile:
    """Return the world of the setting `world`: turtlebot3_world, empty or the path of a file.

    Raises SimulationError when it cannot be read.
    """
    worlds = {DEFAULT_WORLD: _path('turtlebot3_world.urdf')}
    path = user_paths.found(world, but=(world_file.EMPTY, *worlds))
    return world_file.read(path, worlds, mesh_uris.find)


def burger() -> str:
    """Return the path of the burger's URDF."""
    return _path('turtlebot3_burger.urdf')


def _path(name: str) -> str:
    return os.path.join(rospkg.RosPack().get_path('img_recog'), 'urdf', name)
