"""Converts geometry_msgs/Twist and TwistStamped, and the velocities of a drive."""
import math
from typing import Tuple, Union

from geometry_msgs.msg import Twist, TwistStamped

from img_recog.errors import UserError


class TwistError(UserError):
    """A Twist has a number that is not finite."""


def to_msg(linear_x: float, angular_z: float = 0.0, linear_y: float = 0.0) -> Twist:
    """Return the message for m/s and rad/s; every other field is 0.

    >>> to_msg(0.2, -0.5).linear.x, to_msg(0.2, -0.5).angular.z
    (0.2, -0.5)
    """
    msg = Twist()
    msg.linear.x, msg.angular.z, msg.linear.y = linear_x, angular_z, linear_y
    return msg


def from_msg(msg: Union[Twist, TwistStamped]) -> Tuple[float, float, float]:
    """Return linear.x in m/s, angular.z in rad/s and linear.y in m/s.

    >>> from_msg(TwistStamped(twist=to_msg(0.2, -0.5)))
    (0.2, -0.5, 0.0)

    Raises TwistError when any of the six fields is not a finite number.
    """
    twist = msg.twist if isinstance(msg, TwistStamped) else msg
    values = {part + '.' + axis: getattr(getattr(twist, part), axis)
              for part in ('linear', 'angular') for axis in 'xyz'}
    bad = ['{}={}'.format(name, value) for name, value in values.items()
           if not math.isfinite(value)]
    if bad:
        raise TwistError('Twist: got {}, expected finite numbers'.format(', '.join(bad)))
    return twist.linear.x, twist.angular.z, twist.linear.y
