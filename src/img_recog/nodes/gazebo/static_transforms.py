"""The static transforms of the node."""
import itertools
from typing import Dict, Optional, Sequence

import tf2_ros
from geometry_msgs.msg import TransformStamped


class StaticTransforms:
    """Publishes on /tf_static what belongs to robots that come and go.

    All in one message: it is latched, so that a later one would hide those before.
    """

    def __init__(self) -> None:
        self._transforms: Dict[str, Sequence[TransformStamped]] = {}
        self._broadcaster: Optional[tf2_ros.StaticTransformBroadcaster] = None

    def set(self, owner: str, transforms: Sequence[TransformStamped]) -> None:
        """Replace the transforms of an owner, and publish all if there are some."""
        self._transforms[owner] = transforms
        every = list(itertools.chain(*self._transforms.values()))
        if transforms:
            self._broadcaster = self._broadcaster or tf2_ros.StaticTransformBroadcaster()
            self._broadcaster.sendTransform(every)

    def remove(self, owner: str) -> None:
        """Forget the transforms of an owner; tf keeps what it got."""
        self._transforms.pop(owner, None)
