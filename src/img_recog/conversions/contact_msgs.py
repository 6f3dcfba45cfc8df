"""Converts gazebo_msgs/ContactsState.

MISSING says why the package gazebo_msgs cannot be used, '' if it can.
"""
from typing import Any, List

import genpy
import numpy as np
from geometry_msgs.msg import Vector3, Wrench

from img_recog.errors import one_line
from img_recog.simulation.sensors.contact_sensor import ContactSettings, Touch

try:
    from gazebo_msgs.msg import ContactsState, ContactState
    MISSING = ''
except ImportError as error:
    ContactsState = ContactState = None
    MISSING = 'gazebo_msgs cannot be loaded: {}'.format(one_line(error))

_COLLISION = '::collision'      # PyBullet does not keep the names of shapes


def to_msg(touches: List[Touch], settings: ContactSettings, stamp: genpy.Time,
           _: Any = None) -> Any:
    """Return the message for what touches; torques are about the origin of the sensor.

    Like in gazebo_plugins, all is in the world, whatever the frame is called.
    """
    msg = ContactsState(states=[_state(touch) for touch in touches])
    msg.header.frame_id, msg.header.stamp = settings.contact_frame, stamp
    return msg


def from_msg(msg: Any) -> List[Touch]:
    """Return what a message says; the origin, which it does not say, is 0 0 0."""
    return [Touch(state.collision1_name[:-len(_COLLISION)],
                  state.collision2_name[:-len(_COLLISION)],
                  _array(state.contact_positions), _array(state.contact_normals),
                  np.array(state.depths), _array([wrench.force for wrench in state.wrenches]),
                  np.zeros(3)) for state in msg.states]


def _state(touch: Touch) -> Any:
    torques = np.cross(touch.positions - touch.origin, touch.forces)
    return ContactState(
        collision1_name=touch.own + _COLLISION, collision2_name=touch.other + _COLLISION,
        wrenches=[Wrench(Vector3(*force), Vector3(*torque))
                  for force, torque in zip(touch.forces, torques)],
        total_wrench=Wrench(Vector3(*touch.forces.sum(axis=0)), Vector3(*torques.sum(axis=0))),
        contact_positions=[Vector3(*each) for each in touch.positions],
        contact_normals=[Vector3(*each) for each in touch.normals],
        depths=touch.depths.tolist())


def _array(vectors: List[Vector3]) -> np.ndarray:
    return np.array([(vector.x, vector.y, vector.z) for vector in vectors])
