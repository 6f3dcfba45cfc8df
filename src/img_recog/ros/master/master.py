"""What the master knows."""
from typing import Any, Dict, List, Tuple

import rospy

from img_recog import timed_xmlrpc

Users = List[Tuple[str, List[str]]]         # names, and the nodes that use each


class MasterError(Exception):
    """The master does not answer, or refuses a call."""


def system_state() -> Tuple[Users, Users, Users]:
    """Return the topics with their publishers, those with their subscribers, and the services.

    Waits for the master, until the node is shut down. Raises MasterError.
    """
    return _ask('getSystemState')


def topic_types() -> Dict[str, str]:
    """Return the types of topics by their names, also of those without a publisher any more.

    Waits and raises like `system_state`.
    """
    return dict(_ask('getTopicTypes'))


def _ask(method: str) -> Any:
    try:
        code, message, value = getattr(rospy.get_master(), method)()
    except timed_xmlrpc.ERRORS as error:
        raise MasterError('no master answers: {}'.format(error))
    if code != 1:
        raise MasterError(message)
    return value
