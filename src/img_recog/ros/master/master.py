"""What the master knows."""
import http.client
import xmlrpc.client
from typing import List, Tuple

import rospy

Users = List[Tuple[str, List[str]]]         # names, and the nodes that use each


class MasterError(Exception):
    """The master does not answer, or refuses a call."""


def system_state() -> Tuple[Users, Users, Users]:
    """Return the topics with their publishers, those with their subscribers, and the services.

    Waits for the master, until the node is shut down. Raises MasterError.
    """
    try:
        code, message, state = rospy.get_master().getSystemState()
    except (OSError, http.client.HTTPException, xmlrpc.client.Error) as error:
        raise MasterError('no master answers: {}'.format(error))
    if code != 1:
        raise MasterError(message)
    return state
