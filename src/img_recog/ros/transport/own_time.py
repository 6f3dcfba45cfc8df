"""The time of a node that publishes /clock itself."""
import genpy
import rospy

from img_recog.ros.transport.switch import is_plain


def follows_clock_topic() -> bool:
    """Return whether such a node has its time from /clock, like all others.

    It does so in the plain way, and then only if the parameter /use_sim_time is true.
    """
    return is_plain('own_time')


def set_time(now: genpy.Time) -> None:
    """Set this node's own time, which other nodes have from /clock.

    To subscribe to the clock that one publishes costs a quarter of the speed of a simulation.
    """
    if not is_plain('own_time'):
        rospy.rostime._set_rostime(rospy.Time(now.secs, now.nsecs))
