"""When the log says that a robot starts and stops."""
import numpy as np
import pytest

from img_recog.simulation.physics.body import Motion
from img_recog.simulation.sensors.motion_state import MotionState


def moving(linear_x=0.0, angular_z=0.0):
    return Motion(np.zeros(3), (0, 0, 0, 1), np.array([linear_x, 0, 0]),
                  np.array([0, 0, angular_z]))


def spot(before, turn):
    """Return the motions of a robot that turns on the spot and drifts, and what is said."""
    drift = 0.009 * max(1.0, abs(turn))
    first = {0.0: None, 0.2: 'drives forward', -0.2: 'drives backward'}[before]
    return ([(before, 0), (-drift, turn), (drift, turn), (-drift, turn), (0, 0)],
            [first, 'turns left' if turn > 0 else 'turns right', None, None, 'stands'])


@pytest.mark.parametrize('motions, said', [
    # only what is new
    ([(speed, 0) for speed in (0, 0.01, 0.03, 0.5, 0.01, 0.004, 0)],
     [None, None, 'drives forward', None, None, 'stands', None]),
    # a turn began with more than 0.03 rad/s
    ([(-0.2, 0), (0, 0.3), (0, -0.3), (0, -0.03), (0, 0)],
     ['drives backward', 'turns left', 'turns right', None, 'stands']),
    *(spot(before, turn) for before in (0.0, 0.2, -0.2) for turn in (0.3, 1.0, 2.8, -1.0)),
    # in a curve
    *(([(speed, turn), (0.9 * speed, turn), (speed, turn), (0.0, turn)],
       ['drives forward', None, None, 'turns left'])
      for speed, turn in ((0.05, 0.5), (0.1, 2.0), (0.22, 2.8), (0.022, 1.0)))])
def test_what_is_said(motions, said):
    state = MotionState()
    assert [state.update(moving(*motion)) for motion in motions] == said
