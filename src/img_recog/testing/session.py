"""The master and the node of a process that runs tests.

rospy is initialized once in a process, with one master, so all Simulations of a process share
both, one after another.
"""
import atexit
import contextlib
import io
import logging
import os
import sys
from typing import Any, Dict, Iterable, Optional

import rosgraph
import rosmaster.master
import rosnode
import rospy

from img_recog.errors import UserError
from img_recog.ros import timed_xmlrpc
from img_recog.ros.timed_xmlrpc import Master

_NODE = 'simulation_test'
_TIMEOUT_S = 5.0        # of a call of the master
_KEPT = ('run_id', 'rosdistro', 'rosversion', 'roslaunch')
_session: Optional['Session'] = None


def get() -> 'Session':
    """Return the session of this process; the first call starts the master and the node."""
    global _session
    if _session is None:
        _session = Session()
    return _session


class Session:
    """A master and a node. uri: of the master, master: its calls.

    The master is in this process, on a free port of this computer, unless this process is a node
    already, or roslaunch or rostest has started it as one: then it is that which is given.
    """

    def __init__(self) -> None:
        """Start both. Raises UserError if a master that was given does not answer."""
        is_started = any(word.startswith('__name:=') for word in sys.argv)
        if not (is_started or rospy.core.is_initialized()):
            self._start_master()
        self.uri = rosgraph.get_master_uri()
        self.master = Master(self.uri, '/' + _NODE, _TIMEOUT_S)
        try:
            self.master.call('setParam', '/use_sim_time', True)
        except timed_xmlrpc.ERRORS:
            raise UserError('no master answers at {}'.format(self.uri), 'start the test by '
                            'rostest or pytest') from None
        if not rospy.core.is_initialized():
            # signals are for pytest and unittest
            rospy.init_node(_NODE, anonymous=not is_started, disable_signals=True)
        # pytest would show their lines for each failure; the master logs each node that has ended
        for name, level in (('rosmaster', logging.CRITICAL), ('roslaunch', logging.WARNING),
                            ('rospy', logging.WARNING)):
            logging.getLogger(name).setLevel(level)

    def _start_master(self) -> None:
        if not (os.environ.get('ROS_HOSTNAME') or os.environ.get('ROS_IP')):
            os.environ['ROS_HOSTNAME'] = 'localhost'
        master = rosmaster.master.Master(port=0)
        master.start()
        os.environ['ROS_MASTER_URI'] = master.uri
        atexit.register(rospy.signal_shutdown, 'the tests are over')

    def nodes(self) -> Dict[str, Optional[str]]:
        """Return the nodes that the master knows, with their addresses."""
        return {name: self.master.ask('lookupNode', name) for name in self.master.state().nodes}

    def forget(self, names: Iterable[str]) -> None:
        """Have the master forget those of the nodes that were killed: they do not answer."""
        gone = [name for name in names
                if not _answers(self.master.ask('lookupNode', name) or '')]
        with contextlib.redirect_stdout(io.StringIO()):     # a line for each node
            rosnode.cleanup_master_blacklist(rosgraph.Master('/' + _NODE), gone)

    def parameters(self) -> Dict[str, Any]:
        """Return all parameters, by the first part of their names."""
        return self.master.call('getParam', '/')

    def restore(self, before: Dict[str, Any]) -> None:
        """Have the parameters as they were, apart from those of roslaunch."""
        after = self.parameters()
        for name in set(before) | set(after):
            if name in _KEPT or before.get(name) == after.get(name):
                continue
            if name in after:       # setParam would leave what is in a namespace and was not
                self.master.call('deleteParam', '/' + name)
            if name in before:
                self.master.call('setParam', '/' + name, before[name])


def _answers(uri: str) -> bool:
    try:
        timed_xmlrpc.server(uri).getPid('/' + _NODE)
    except timed_xmlrpc.ERRORS:
        return False
    return True
