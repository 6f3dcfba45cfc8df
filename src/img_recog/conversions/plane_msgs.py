"""Converts poses and outlines in the x-y plane of a frame."""
import math
from typing import List, NamedTuple, Sequence, Union

import genpy
import numpy as np
from geometry_msgs.msg import (Point, PoseStamped, PoseWithCovariance,
                               PoseWithCovarianceStamped)
from std_msgs.msg import Header
from visualization_msgs.msg import Marker, MarkerArray

from img_recog import rotations
from img_recog.errors import UserError

MAX_NUMBER = 1e6        # in m; physics engines compute NaN far beyond
# of x, y and yaw, in m^2 and rad^2, by their places in the matrix
_INITIAL_VARIANCES = {0: 0.25, 7: 0.25, 35: (math.pi / 12) ** 2}
_LINE_WIDTH_M = 0.02
_GRAY = 0.5


class PoseError(UserError):
    """A pose has a number that is not finite or too large, or no rotation about z."""


class PlanePose(NamedTuple):
    """Position in m and heading in rad."""

    x: float
    y: float
    yaw: float

    def compose(self, pose: 'PlanePose') -> 'PlanePose':
        """Return, in the parent's frame, a pose that is given in the frame of this one.

        >>> PlanePose(1.0, 2.0, 0.0).compose(PlanePose(0.5, 0.0, 0.25))
        PlanePose(x=1.5, y=2.0, yaw=0.25)
        """
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return PlanePose(self.x + cos * pose.x - sin * pose.y,
                         self.y + sin * pose.x + cos * pose.y, self.yaw + pose.yaw)

    def inverse(self) -> 'PlanePose':
        """Return the pose of the parent in the frame of this pose.

        >>> PlanePose(1.0, 2.0, 0.0).inverse()
        PlanePose(x=-1.0, y=-2.0, yaw=-0.0)
        """
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        return PlanePose(-cos * self.x - sin * self.y, sin * self.x - cos * self.y, -self.yaw)


def pose_to_msg(pose: PlanePose, header: Header) -> PoseStamped:
    """Return the message for a pose."""
    msg = PoseStamped(header=header)
    msg.pose.position.x, msg.pose.position.y = pose.x, pose.y
    _, _, msg.pose.orientation.z, msg.pose.orientation.w = rotations.of_yaw(pose.yaw)
    return msg


def initial_pose(pose: PoseStamped) -> PoseWithCovarianceStamped:
    """Return the message that tells a pose to amcl, with the variances that rviz gives it."""
    covariance = [_INITIAL_VARIANCES.get(index, 0.0) for index in range(36)]
    return PoseWithCovarianceStamped(pose.header, PoseWithCovariance(pose.pose, covariance))


def pose_from_msg(msg: Union[PoseStamped, PoseWithCovariance]) -> PlanePose:
    """Return the pose in a message; its height, roll and pitch are ignored.

    >>> pose_from_msg(pose_to_msg(PlanePose(1.0, 2.0, 0.5), Header()))
    PlanePose(x=1.0, y=2.0, yaw=0.5)

    Raises PoseError when a number is not finite or above MAX_NUMBER, or the quaternion is zero.
    """
    position, turn = msg.pose.position, msg.pose.orientation
    numbers = (position.x, position.y, turn.x, turn.y, turn.z, turn.w)
    if not all(map(math.isfinite, numbers)):
        raise PoseError('got a pose with x {}, y {} and the quaternion ({}, {}, {}, {}), expected '
                        'finite numbers'.format(*numbers))
    if max(abs(number) for number in numbers) > MAX_NUMBER:
        raise PoseError('got a pose with x {:g}, y {:g} and the quaternion ({:g}, {:g}, {:g}, '
                        '{:g}), expected numbers up to {:g}'.format(*numbers, MAX_NUMBER))
    if not any(numbers[2:]):
        raise PoseError('got a pose with a quaternion of zeros, expected a rotation')
    return PlanePose(position.x, position.y, rotations.yaw(numbers[2:]))


def outlines_to_msg(outlines: Sequence[np.ndarray], origin: PlanePose, frame_id: str,
                    stamp: genpy.Time) -> MarkerArray:
    """Return outlines (corners, 2) in m as closed lines, which replace all earlier ones.

    origin: the pose of the frame `frame_id` in the frame of the outlines.
    """
    x, y, yaw = origin.inverse()
    turn = np.array([[math.cos(yaw), -math.sin(yaw)], [math.sin(yaw), math.cos(yaw)]])
    header = Header(stamp=stamp, frame_id=frame_id)
    markers = [Marker(header=header, ns='outlines', action=Marker.DELETEALL)]
    for number, corners in enumerate(outlines):
        outline = corners @ turn.T + (x, y)
        marker = Marker(header=header, ns='outlines', id=number, type=Marker.LINE_STRIP,
                        action=Marker.ADD)
        marker.pose.orientation.w = 1.0
        marker.scale.x = _LINE_WIDTH_M
        marker.color.r = marker.color.g = marker.color.b = _GRAY
        marker.color.a = 1.0
        marker.points = [Point(x, y, 0.0) for x, y in [*outline.tolist(), outline[0].tolist()]]
        markers.append(marker)
    return MarkerArray(markers)


def outlines_from_msg(msg: MarkerArray) -> List[np.ndarray]:
    """Return the outlines (corners, 2) in m of the closed lines in a message.

    Corners with a number that is not finite or above MAX_NUMBER are left out.
    """
    outlines = [np.array([(point.x, point.y) for point in marker.points[:-1]
                          if abs(point.x) <= MAX_NUMBER and abs(point.y) <= MAX_NUMBER])
                for marker in msg.markers if marker.type == Marker.LINE_STRIP]
    return [outline for outline in outlines if len(outline)]
