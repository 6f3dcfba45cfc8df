"""The time of a node that publishes /clock itself."""
import genpy
import rospy

from img_recog.ros.transport.switch import is_plain


def follows_clock_topic() -> bool:
    """Return whether such a node gets its time from /clock, like all other nodes.

    It does without this module's help, and only if the parameter /use_sim_time is true; else its
    time is the wall's.
    """
    return is_plain('own_time')


def set_time(now: genpy.Time) -> None:
    """Set this node's own time, which other nodes get from /clock.

    A node that subscribes to the clock that it publishes simulates slower.
    """
    if not is_plain('own_time'):
        rospy.rostime._set_rostime(rospy.Time(now.secs, now.nsecs))
