"""Reads the parameters of the controllers of ros_control that a robot can have."""
from typing import Any, Dict, Mapping

import rospy

from img_recog.nodes.gazebo.names import Names
from img_recog.ros import parameters
from img_recog.simulation.descriptions import drive_controllers, drive_tags
from img_recog.simulation.descriptions.drive_controllers import Controllers
from img_recog.simulation.settings import SimulationError


def read(urdf: str, names: Names) -> Controllers:
    """Return the parameters of controllers, by the names that these have in the robot's namespace.

    They are on the parameter server in the namespace of the plugin in the text of the URDF, below
    that of the robot, or for all robots below that of this node. Which of them a controller
    manager would start is not known. There are none if `urdf` is not a URDF.
    """
    try:
        inner = drive_tags.control_namespace(urdf)
    except SimulationError:
        inner = None        # who reads the robot says what is wrong
    if inner is None:
        return {}
    if inner == names.namespace:
        inner = ''
    of_robot = '/'.join(filter(None, (names.namespace, inner)))
    found: Dict[str, Mapping[str, Any]] = {}
    for namespace in (of_robot, inner):
        values = parameters.value(rospy.get_namespace() + namespace)
        for name, value in drive_controllers.among(values, inner).items():
            found.setdefault(name, value)
    return found
