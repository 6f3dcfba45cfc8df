"""The motion of a robot in words, for the log."""
from typing import Optional

from img_recog.simulation.physics.body import Motion

# m/s and rad/s: above the first a robot has started to move, below the second it has stopped
_STARTS, _STOPS = (0.02, 0.05), (0.005, 0.01)
# m: a robot that turns on the spot drifts, the burger with a radius of 8 mm. So it drives only if
# its path has a larger radius; while it drives, three quarters of that are enough
_SPOT_RADIUS, _STILL_DRIVES = 0.02, 0.75


class MotionState:
    """Notices when a robot changes between standing, driving and turning."""

    def __init__(self):
        self._words = 'stands'

    def update(self, motion: Motion) -> Optional[str]:
        """Return what the robot does now if that has changed, else None."""
        linear, angular = _STOPS if self._words != 'stands' else _STARTS
        turning = abs(motion.angular[2])
        if turning > angular:
            linear = max(_STARTS[0], _SPOT_RADIUS * turning)
            linear *= _STILL_DRIVES if self._words.startswith('drives') else 1.0
        if abs(motion.linear[0]) > linear:
            words = 'drives forward' if motion.linear[0] > 0 else 'drives backward'
        elif turning > angular:
            words = 'turns left' if motion.angular[2] > 0 else 'turns right'
        else:
            words = 'stands'
        if words == self._words:
            return None
        self._words = words
        return words
