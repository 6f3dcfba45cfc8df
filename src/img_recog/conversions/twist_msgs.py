"""Converts geometry_msgs/Twist and the two velocities of a differential drive."""
import math
from typing import Tuple

from geometry_msgs.msg import Twist

from img_recog.errors import UserError


class TwistError(UserError):
    """A Twist has a number that is not finite."""


def to_msg(linear_x: float, angular_z: float = 0.0) -> Twist:
    """Return the message for linear_x m/s and angular_z rad/s; every other field is 0.

    >>> to_msg(0.2, -0.5).linear.x, to_msg(0.2, -0.5).angular.z
    (0.2, -0.5)
    """
    msg = Twist()
    msg.linear.x, msg.angular.z = linear_x, angular_z
    return msg


def from_msg(msg: Twist) -> Tuple[float, float]:
    """Return linear.x in m/s and angular.z in rad/s.

    >>> from_msg(to_msg(0.2, -0.5))
    (0.2, -0.5)

    Raises TwistError when any of the six fields is not a finite number.
    """
    values = {part + '.' + axis: getattr(getattr(msg, part), axis)
              for part in ('linear', 'angular') for axis in 'xyz'}
    bad = ['{}={}'.format(name, value) for name, value in values.items()
           if not math.isfinite(value)]
    if bad:
        raise TwistError('Twist: got {}, expected finite numbers'.format(', '.join(bad)))
    return msg.linear.x, msg.angular.z
