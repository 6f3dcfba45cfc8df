"""The transforms of the node: those of robots on /tf, and static ones."""
import itertools
from typing import Dict, List, Optional, Sequence

import tf2_ros
from geometry_msgs.msg import Transform, TransformStamped, Vector3
from std_msgs.msg import Header
from tf2_msgs.msg import TFMessage

from img_recog.conversions import plane_msgs
from img_recog.conversions.plane_msgs import PlanePose
from img_recog.ros.transport.direct_publisher import DirectPublisher


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


class Transforms:
    """Publishes on /tf, the topic of tf2_ros: the transforms of all robots in one message."""

    def __init__(self) -> None:
        self._publisher = DirectPublisher('/tf', TFMessage)
        self._waiting: List[TransformStamped] = []

    def add(self, transform: TransformStamped) -> None:
        """Add a transform to those that are published next; until then it must not be changed,
        except for the next call.
        """
        self._waiting.append(transform)

    def separate(self, transform: TransformStamped) -> None:
        """Call before a transform is changed: what was added so far is a message."""
        if any(each is transform for each in self._waiting):
            self._serialize()

    def flush(self) -> None:
        """Publish what was added."""
        self._serialize()
        self._publisher.flush()

    def _serialize(self) -> None:
        if self._waiting:
            self._publisher.add(TFMessage(self._waiting))
            self._waiting = []


def plane_transform(pose: PlanePose, parent: str, child: str) -> TransformStamped:
    """Return the transform of a pose on the floor, without a time."""
    given = plane_msgs.pose_to_msg(pose, Header(frame_id=parent))
    return TransformStamped(given.header, child, Transform(
        Vector3(*pose[:2], 0.0), given.pose.orientation))
