"""When the log says that a robot starts and stops."""
import numpy as np
import pytest

from img_recog.simulation.physics.body import Motion
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
    assert state.update(moving(0, -0.03)) is None       # it began with more
    assert state.update(moving()) == 'stands'


@pytest.mark.parametrize('turning', [0.3, 1.0, 2.8, -1.0])
@pytest.mark.parametrize('before', [0.0, 0.2, -0.2])
def test_a_robot_that_turns_on_the_spot_and_drifts_turns(turning, before):
    state = MotionState()
    state.update(moving(before))
    drift = 0.009 * max(1.0, abs(turning))
    changes = [state.update(moving(linear_x, turning)) for linear_x in (-drift, drift, -drift)]
    assert changes == ['turns left' if turning > 0 else 'turns right', None, None]
    assert state.update(moving()) == 'stands'


@pytest.mark.parametrize('linear_x, angular_z', [(0.05, 0.5), (0.1, 2.0), (0.22, 2.8)])
def test_a_robot_in_a_curve_drives(linear_x, angular_z):
    state = MotionState()
    changes = [state.update(moving(share * linear_x, angular_z)) for share in (1.0, 0.9, 1.0)]
    assert changes == ['drives forward', None, None]
    assert state.update(moving(0.0, angular_z)) == 'turns left'
