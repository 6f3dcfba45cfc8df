"""A master for several tests."""
import threading

import pytest

from img_recog_helpers.waiting import DEADLINE_S
from img_recog_helpers.xmlrpc_server import XmlRpcServer


class FakeMaster:
    """The calls of a master that are used here, by real XML-RPC.

    free: calls are answered only while it is set.
    """

    def __init__(self):
        self.free = threading.Event()
        self.free.set()
        self.renew()
        self._server = XmlRpcServer(dispatch=self._call)
        self.uri, self.port = self._server.uri, self._server.port

    def renew(self, parameters=(), nodes=()):
        """Be another master from now on."""
        self.parameters, self.nodes = dict(parameters), dict(nodes)

    def stop(self):
        self._server.stop()

    def start(self):
        self._server = XmlRpcServer(self.port, self._call)

    def _call(self, method, caller, name='', value=None):
        self.free.wait(DEADLINE_S)
        if method == 'lookupNode':
            return (1, '', self.nodes[name]) if name in self.nodes else (-1, 'unknown', '')
        if method == 'hasParam':
            return 1, '', name in self.parameters
        if method == 'setParam':
            self.parameters[name] = value
            return 1, '', 0
        if method == 'searchParam':
            found = '/robot_description' in self.parameters
            return (1, '', '/robot_description') if found else (-1, 'none', '')
        if method == 'getParam':
            below = {key[len(name) + 1:]: each for key, each in self.parameters.items()
                     if key.startswith(name + '/')}
            found = self.parameters.get(name, below or None)
            return (1, '', found) if found is not None else (-1, 'none', 0)
        raise AssertionError(method)


@pytest.fixture
def master(monkeypatch):
    """A master without nodes and parameters."""
    master = FakeMaster()
    monkeypatch.setenv('ROS_MASTER_URI', master.uri)
    yield master
    master.free.set()
    master.stop()
