"""Reads the parameters of the controllers of ros_control that a robot can have."""
from typing import Any, Dict, Mapping

import rospy

from img_recog.formats import drive_controllers
from img_recog.formats.drive_controllers import Controllers
from img_recog.ros import parameters
from img_recog.simulation.simulation_settings import Names


def read(names: Names, namespace: str) -> Controllers:
    """Return the parameters of controllers, by the names that these have in the robot's namespace.

    They are on the parameter server in a namespace, that of the plugin in the URDF, below that of
    the robot, or for all robots below that of this node. Which of them a controller manager would
    start is not known.
    """
    inner = '' if namespace == names.namespace else namespace
    of_robot = '/'.join(filter(None, (names.namespace, inner)))
    found: Dict[str, Mapping[str, Any]] = {}
    for each in (of_robot, inner):
        values = parameters.value(rospy.get_namespace() + each)
        for name, value in drive_controllers.among(values, inner).items():
            found.setdefault(name, value)
    return found
