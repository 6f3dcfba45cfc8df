"""The watch notices a new master, and sets the parameters that it does not have."""
import errno
import socket
import xmlrpc.client

import pytest
import rospy

from img_recog.ros.master import master_watch
from img_recog.ros.master.master_watch import MasterWatch

URI = 'http://node:1/'


class FakeMaster:
    """The calls of a master that the watch uses."""

    def __init__(self, parameters=()):
        self.parameters, self.nodes, self.failure = dict(parameters), {}, None
        self.publishers = []

    def __getattr__(self, method):
        return lambda *arguments: self.call(method, *arguments)

    def call(self, method, caller, name='', value=None):
        if self.failure is not None:
            raise self.failure
        if method == 'lookupNode':
            return (1, '', self.nodes[name]) if name in self.nodes else (-1, 'unknown', '')
        if method == 'getSystemState':
            return 1, '', [self.publishers, [], []]
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


class FakeMultiCall:
    """Calls one after the other, as one request."""

    def __init__(self, proxy):
        self._proxy, self._calls = proxy, []

    def __getattr__(self, method):
        return lambda *arguments: self._calls.append((method, arguments))

    def __call__(self):
        return [self._proxy.call(method, *arguments) for method, arguments in self._calls]


@pytest.fixture
def lines(monkeypatch):
    """The log lines."""
    lines = []
    for level in ('loginfo', 'logwarn'):
        monkeypatch.setattr(rospy, level, lambda text, *words: lines.append(text % words))
    return lines


@pytest.fixture
def watch(monkeypatch, lines):
    """A watch whose master has the node and some parameters."""
    monkeypatch.setenv('ROS_MASTER_URI', 'http://master:1')
    monkeypatch.setattr(rospy, 'get_name', lambda: '/node')
    monkeypatch.setattr(rospy, 'get_node_uri', lambda: URI)
    monkeypatch.setattr(master_watch.xmlrpc.client, 'MultiCall', FakeMultiCall)
    watch = MasterWatch()
    watch._proxy = FakeMaster({'/node/rate': 30, '/node/name': 'x', '/use_sim_time': True,
                               '/robot_description': '<robot/>', '/other': 1})
    watch._proxy.nodes['/node'] = URI

    def register_again(call):
        call('hasParam', '/anything')
        watch._proxy.nodes['/node'] = URI
        return master_watch.registration.Registered(5, 2)
    monkeypatch.setattr(master_watch.registration, 'register_again', register_again)
    watch._poll_safely()
    return watch


def test_a_known_node_is_not_registered_again(watch, lines):
    watch._poll_safely()
    assert lines == []


def test_a_new_master_gets_the_parameters_it_does_not_have(watch, lines):
    watch._proxy.parameters['/node/rate'] = 15      # changed while the node runs
    watch._poll_safely()
    watch._proxy = FakeMaster({'/node/name': 'y'})
    watch._poll_safely()
    assert watch._proxy.parameters == {
        '/node/rate': 15, '/node/name': 'y', '/use_sim_time': True,
        '/robot_description': '<robot/>'}
    assert lines == ['a master answers at http://master:1: registered again, topics 5, '
                     'services 2, parameters 3']
    watch._poll_safely()
    assert len(lines) == 1


def test_a_master_that_is_gone_is_logged_once_and_so_is_its_return(watch, lines):
    watch._proxy.failure = ConnectionRefusedError(errno.ECONNREFUSED, 'Connection refused')
    for _ in range(3):
        watch._poll_safely()
    assert len(lines) == 1 and lines[0].startswith(
        'the master at http://master:1 does not answer: Connection refused')
    watch._proxy.failure = None
    watch._poll_safely()
    watch._poll_safely()
    assert lines[1:] == ['a master answers at http://master:1: registered again, topics 5, '
                         'services 2, parameters 0']


def test_a_busy_master_may_miss_a_poll(watch, lines):
    watch._proxy.failure = socket.timeout('timed out')
    for _ in range(2):
        watch._poll_safely()
    assert lines == []
    watch._poll_safely()
    assert len(lines) == 1 and 'timed out' in lines[0]


def test_parameters_that_cannot_be_read_are_not_silence_of_the_master(watch, lines, monkeypatch):
    def fault(_):
        raise xmlrpc.client.Fault(1, 'int exceeds XML-RPC limits')
    with monkeypatch.context() as patch:
        patch.setattr(FakeMultiCall, '__call__', fault)
        for _ in range(3):
            watch._poll_safely()
    assert len(lines) == 1 and 'rosparam delete /node/NAME' in lines[0]
    assert 'parameters in /node' in lines[0] and 'int exceeds XML-RPC limits' in lines[0]
    assert watch._polls == 4        # as of a master that answers
    watch._proxy = FakeMaster()
    watch._poll_safely()
    assert watch._proxy.parameters['/node/rate'] == 30


def test_a_registration_that_fails_is_repeated(watch, lines, monkeypatch):
    register_again, failures = master_watch.registration.register_again, [xmlrpc.client.Error('x')]

    def failing(call):
        if failures:
            watch._proxy.nodes['/node'] = URI       # a part of it has succeeded
            raise failures.pop()
        return register_again(call)
    monkeypatch.setattr(master_watch.registration, 'register_again', failing)
    watch._proxy = FakeMaster()
    watch._poll_safely()
    watch._poll_safely()
    assert 'registered again' in lines[-1] and watch._proxy.parameters['/node/rate'] == 30


def test_a_node_that_was_replaced_is_not_registered_again(watch, lines):
    watch._proxy.nodes['/node'] = 'http://other:1/'
    watch._poll_safely()
    assert watch._ended.is_set() and lines == []


@pytest.fixture
def connected(watch, monkeypatch):
    """What the watch connects; /image is published by a node that runs and one that does not."""
    connected = []
    monkeypatch.setattr(master_watch.registration, 'connections', lambda: {'/image': 0})
    monkeypatch.setattr(master_watch.registration, 'unconnected_topics',
                        lambda publishers: {'/image'} & set(publishers))
    monkeypatch.setattr(master_watch.registration, 'connect',
                        lambda *words: connected.append(words))
    monkeypatch.setattr(MasterWatch, '_answers', lambda self, uri: uri == 'http://camera:1/')
    watch._proxy.nodes.update({'/camera': 'http://camera:1/', '/dead': 'http://dead:1/'})
    watch._proxy.publishers = [['/image', ['/unknown', '/dead', '/camera']], ['/clock', ['/sim']]]
    return connected


def test_a_lost_connection_is_made_again(watch, connected):
    watch._poll_safely()
    assert connected == []          # rospy may be about to connect
    watch._poll_safely()
    assert connected == [('/image', 'http://camera:1/')]


def test_a_connection_that_is_back_is_left_alone(watch, connected):
    watch._poll_safely()
    publishers, watch._proxy.publishers = watch._proxy.publishers, []
    watch._poll_safely()
    watch._proxy.publishers = publishers
    watch._poll_safely()
    assert connected == []


def test_publishers_are_read_if_a_connection_may_be_missing_and_from_time_to_time(
        watch, connected, monkeypatch):
    read = []
    call = watch._proxy.call

    def counted(method, *arguments):
        read.append(method == 'getSystemState')
        return call(method, *arguments)
    monkeypatch.setattr(watch._proxy, 'call', counted)
    monkeypatch.setattr(master_watch.registration, 'unconnected_topics', lambda _: set())

    def is_read(count):
        monkeypatch.setattr(master_watch.registration, 'connections', lambda: {'/image': count})
        del read[:]
        watch._poll_safely()
        return any(read)
    # the fixture has polled once
    assert [is_read(count) for count in (0, 1, 2, 2, 1, 1, 1, 1, 1, 1)] == [
        True, False, False, True, True, False, False, False, True, False]


def test_a_node_that_does_not_answer_is_not_connected(watch):
    with socket.socket() as suspended:
        suspended.bind(('127.0.0.1', 0))
        suspended.listen(1)
        assert not watch._answers('http://127.0.0.1:{}/'.format(suspended.getsockname()[1]))
