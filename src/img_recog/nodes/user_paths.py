"""Paths that a user types, from the folder that the user stands in."""
import os


def folders() -> tuple:
    """Return where a relative path is looked for.

    roslaunch starts nodes in ROS_HOME; PWD still names the folder that the user stood in.
    """
    return os.environ.get('PWD', ''), os.getcwd()


def found(path: str) -> str:
    """Return the first existing path that a relative one may mean, or what was given."""
    candidates = (os.path.join(folder, os.path.expanduser(path)) for folder in folders())
    return next(filter(os.path.isfile, candidates), path)
