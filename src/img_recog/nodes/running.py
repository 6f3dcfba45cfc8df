"""From a script to a running node and back to an exit code."""
from typing import Callable

import rospy

from img_recog.errors import UserError


def run(name: str, serve: Callable[[], None]) -> int:
    """Start the node `name`, call `serve` until it returns, and return the exit code.

    What a user can mend ends the node with one line at FATAL and code 1; being shut down is
    code 0.
    """
    rospy.init_node(name)
    try:
        serve()
    except rospy.ROSException:
        # a node that is shut down from outside finds its topics closed while it publishes, and
        # that before is_shutdown says so
        if not rospy.core.is_shutdown_requested():
            raise
    except UserError as error:
        rospy.logfatal('%s', ' '.join(str(error).split()))
        rospy.signal_shutdown('cannot go on')
        return 1
    return 0
