"""Paths that a user types, from the folder that the user stands in."""
import os
from typing import Sequence


def folders() -> tuple:
    """Return where a relative path is looked for.

    roslaunch starts nodes in ROS_HOME; PWD still names the folder that the user stood in.
    """
    return os.environ.get('PWD', ''), os.getcwd()


def found(path: str, but: Sequence[str] = ()) -> str:
    """Return the first existing file that a relative path may mean, else what was given.

    but: names that mean something else, whatever files there are.
    """
    if path in but:
        return path
    candidates = (os.path.join(folder, os.path.expanduser(path)) for folder in folders())
    return next(filter(os.path.isfile, candidates), path)
