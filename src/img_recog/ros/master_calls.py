"""The calls of this node to the master."""
import rosgraph
import rospy

from img_recog.ros.timed_xmlrpc import Master

_TIMEOUT_S = 5.0


def calls() -> Master:
    """Return what calls the master; see there for what is raised."""
    return Master(rosgraph.get_master_uri(), rospy.get_name(), _TIMEOUT_S)
