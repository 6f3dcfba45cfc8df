"""When the log says that a robot starts and stops."""
import numpy as np

from img_recog.simulation.bodies.body import Motion
from img_recog.simulation.sensors.motion_state import MotionState


def moving(linear_x=0.0, angular_z=0.0):
    return Motion(np.zeros(3), (0, 0, 0, 1), np.array([linear_x, 0, 0]),
                  np.array([0, 0, angular_z]))


def test_says_only_what_is_new():
    state = MotionState()
    changes = [state.update(moving(speed)) for speed in (0, 0.01, 0.03, 0.5, 0.01, 0.004, 0)]
    assert changes == [None, None, 'drives forward', None, None, 'stands', None]


def test_backward_and_turning():
    state = MotionState()
    assert state.update(moving(-0.2)) == 'drives backward'
    assert state.update(moving(0, 0.3)) == 'turns left'
    assert state.update(moving(0, -0.3)) == 'turns right'
    assert state.update(moving()) == 'stands'
