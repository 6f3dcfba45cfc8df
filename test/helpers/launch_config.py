"""What roslaunch reads from a launch file; roslaunch itself takes a second to start."""
import os

from roslaunch.config import ROSLaunchConfig, load_config_default

from img_recog_helpers.pages import LAUNCH_FOLDER


def launch_config(name: str, *arguments: str) -> ROSLaunchConfig:
    """Return nodes and parameters of a launch file of the package, each node on its machine."""
    return load_config_default([(os.path.join(LAUNCH_FOLDER, name), list(arguments))], None)
