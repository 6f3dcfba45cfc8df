"""For which nodes simulated time waits, and for how long."""
from dataclasses import dataclass
from typing import FrozenSet, List, Tuple

import rosgraph
import rospy

from img_recog.settings import Allowed, Settings, above, one_of, setting
from img_recog.simulation.sensors.robot_camera import CAMERA

# kinds of sensors by the names that users give
KINDS = {'image': CAMERA, 'scan': 'scan', 'odom': 'odometry', 'imu': 'imu',
         'joint_states': 'joint_states'}
END = 'end'


@dataclass(frozen=True)
class LockstepSettings(Settings):
    """For whom simulated time waits.

    lockstep: topics, with spaces or commas between them, or none; after a message of the sensors
    in lockstep_sensors, time stands until an answer has come on each. lockstep_timeout: wall s
    without one, after which the node does what lockstep_at_timeout says.
    """

    lockstep: str = setting('none', Allowed('names of topics, or none', lambda text: bool(
        _words(text)) and all(map(rosgraph.names.is_legal_name, _words(text)))))
    lockstep_sensors: str = setting('image', Allowed(
        'some of ' + ', '.join(KINDS),
        lambda text: bool(_words(text)) and set(_words(text)) <= set(KINDS)))
    lockstep_timeout: float = setting(5.0, above(0))
    lockstep_at_timeout: str = setting('continue', one_of('continue', END))

    @property
    def topics(self) -> Tuple[str, ...]:
        """The resolved names of the topics."""
        names = [] if self.lockstep == 'none' else _words(self.lockstep)
        return tuple(dict.fromkeys(map(rospy.resolve_name, names)))

    @property
    def kinds(self) -> FrozenSet[str]:
        """The kinds of sensors whose messages are answered."""
        return frozenset(KINDS[name] for name in _words(self.lockstep_sensors))


def _words(text: str) -> List[str]:
    return text.replace(',', ' ').split()
