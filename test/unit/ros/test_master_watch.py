"""The watch notices a new master, and sets the parameters that it does not have."""
import xmlrpc.client

import pytest
import rospy

from img_recog.ros import master_watch
from img_recog.ros.master_watch import MasterWatch
from img_recog_helpers.waiting import DEADLINE_S

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
        return 5, 2
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
