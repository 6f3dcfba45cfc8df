"""The watch notices a new master, and sets the parameters that it does not have."""
import socket
import xmlrpc.client

import pytest
import rospy

from img_recog.ros.master import master_watch
from img_recog.ros.master.master_watch import MasterWatch
from img_recog_testing.waiting import DEADLINE_S
from img_recog_testing.xmlrpc_server import XmlRpcServer

URI = 'http://node:1/'
PARAMETERS = {'/node/rate': 30, '/node/name': 'x', '/use_sim_time': True,
              '/robot_description': '<robot/>', '/other': 1}


@pytest.fixture
def lines(monkeypatch):
    """The log lines."""
    lines = []
    for level in ('loginfo', 'logwarn'):
        monkeypatch.setattr(rospy, level, lambda text, *words: lines.append(text % words))
    return lines


@pytest.fixture
def timeout_s():
    """The time limit of a call; a busy machine needs longer than the usual one."""
    return DEADLINE_S


@pytest.fixture
def watch(monkeypatch, lines, master, timeout_s):
    """A watch that has looked once."""
    master.renew(PARAMETERS, {'/node': URI})
    monkeypatch.setattr(rospy, 'get_name', lambda: '/node')
    monkeypatch.setattr(rospy, 'get_node_uri', lambda: URI)

    def register_again(call):
        call('hasParam', '/anything')
        master.nodes['/node'] = URI
        return master_watch.registration.Registered(5, 2)
    monkeypatch.setattr(master_watch.registration, 'register_again', register_again)
    watch = MasterWatch(timeout_s)
    watch.poll()
    return watch


def registered(master, parameters):
    return ('a master answers at {}: registered again, topics 5, services 2, parameters {}'
            .format(master.uri, parameters))


def test_a_known_node_is_not_registered_again(watch, lines):
    watch.poll()
    assert lines == []


def test_a_new_master_gets_the_parameters_it_does_not_have(watch, master, lines):
    master.parameters['/node/rate'] = 15      # changed while the node runs
    watch.poll()
    master.renew({'/node/name': 'y'})
    watch.poll()
    assert master.parameters == {'/node/rate': 15, '/node/name': 'y', '/use_sim_time': True,
                                 '/robot_description': '<robot/>'}
    assert lines == [registered(master, 3)]
    watch.poll()
    assert len(lines) == 1


def test_a_master_that_is_gone_is_logged_once_and_so_is_its_return(watch, master, lines):
    master.stop()
    for _ in range(3):
        watch.poll()
    assert len(lines) == 1 and lines[0].startswith(
        'the master at {} does not answer: Connection refused'.format(master.uri))
    master.start()
    watch.poll()
    watch.poll()
    assert lines[1:] == [registered(master, 0)]


@pytest.mark.parametrize('timeout_s', [0.3])
def test_a_busy_master_may_miss_a_poll(watch, master, lines):
    master.free.clear()
    for _ in range(2):
        watch.poll()
    assert lines == []
    watch.poll()
    assert len(lines) == 1 and 'timed out' in lines[0]


def test_parameters_that_cannot_be_read_are_not_silence_of_the_master(watch, master, lines):
    master.parameters['/node/wide'] = 1 << 40
    for _ in range(3):
        watch.poll()
    assert len(lines) == 1 and 'rosparam delete /node/NAME' in lines[0]
    assert 'parameters in /node' in lines[0] and 'int exceeds XML-RPC limits' in lines[0]
    master.renew({})
    watch.poll()
    assert master.parameters['/node/rate'] == 30


def test_a_registration_that_fails_is_repeated(watch, master, lines, monkeypatch):
    register_again, failures = master_watch.registration.register_again, [xmlrpc.client.Error('x')]

    def failing(call):
        if failures:
            master.nodes['/node'] = URI       # a part of it has succeeded
            raise failures.pop()
        return register_again(call)
    monkeypatch.setattr(master_watch.registration, 'register_again', failing)
    master.renew({})
    watch.poll()
    watch.poll()
    assert 'registered again' in lines[-1] and master.parameters['/node/rate'] == 30


def test_a_node_that_was_replaced_is_not_registered_again(watch, master, lines):
    master.nodes['/node'] = 'http://other:1/'
    watch.poll()
    assert watch.has_ended and lines == []


@pytest.fixture
def connected(watch, master, monkeypatch):
    """What the watch connects; of the publishers of /image, only /camera answers in time."""
    connected = []
    monkeypatch.setattr(master_watch.registration, 'connections', lambda: {'/image': 0})
    monkeypatch.setattr(master_watch.registration, 'unconnected_topics',
                        lambda publishers: {'/image'} & set(publishers))
    monkeypatch.setattr(master_watch.registration, 'connect',
                        lambda *words: connected.append(words))
    camera = XmlRpcServer(getPid=lambda _: [1, '', 1])
    with socket.socket() as suspended:
        suspended.bind(('127.0.0.1', 0))
        suspended.listen(1)
        master.nodes.update({
            '/camera': camera.uri, '/dead': 'http://127.0.0.1:1/',
            '/suspended': 'http://127.0.0.1:{}/'.format(suspended.getsockname()[1])})
        master.publishers = [['/image', ['/unknown', '/dead', '/suspended', '/camera']],
                             ['/clock', ['/sim']]]
        yield [connected, [('/image', camera.uri)]]
    camera.stop()


@pytest.mark.parametrize('timeout_s', [1.0])
def test_a_lost_connection_is_made_again(watch, connected):
    connected, wanted = connected
    watch.poll()
    assert connected == []          # rospy may be about to connect
    watch.poll()
    assert connected == wanted


def test_a_connection_that_is_back_is_left_alone(watch, master, connected):
    watch.poll()
    publishers, master.publishers = master.publishers, []
    watch.poll()
    master.publishers = publishers
    watch.poll()
    assert connected[0] == []


def test_publishers_are_read_if_a_connection_may_be_missing_and_from_time_to_time(
        watch, master, monkeypatch):
    monkeypatch.setattr(master_watch.registration, 'unconnected_topics', lambda _: set())

    def is_read(count):
        monkeypatch.setattr(master_watch.registration, 'connections', lambda: {'/image': count})
        del master.calls[:]
        watch.poll()
        return 'getSystemState' in master.calls
    # the fixture has polled once
    assert [is_read(count) for count in (0, 1, 2, 2, 1, 1, 1, 1, 1, 1)] == [
        True, False, False, True, True, False, False, False, True, False]
