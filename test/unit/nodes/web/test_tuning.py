"""Parameters of another node, with a stand-in for the client of dynamic_reconfigure."""
import argparse
import threading

import pytest
import rospy
from dynamic_reconfigure import DynamicReconfigureCallbackException

from img_recog.nodes.web import tuning
from img_recog.nodes.web.tuning import Tuning
from img_recog_helpers.waiting import DEADLINE_S, wait_for


class Client:
    """Counts how many are open at a time; `block` holds the updates."""

    opened, open_now, most_open = 0, 0, 0
    address = 'http://localhost:1/'     # that the master knows, None for an unknown node
    updates, descriptions, block, fails, fails_to_update = [], [{'name': 'a'}], None, 0, None
    is_updating = False

    def __init__(self, node, timeout, config_callback, description_callback):
        cls = Client
        if cls.fails:
            cls.fails -= 1
            raise rospy.ROSException('timeout exceeded while waiting for service')
        cls.opened, cls.open_now = cls.opened + 1, cls.open_now + 1
        cls.most_open = max(cls.most_open, cls.open_now)
        config_callback({'a': 1, 'groups': {}})
        if Client.descriptions:
            description_callback(Client.descriptions)

    def update_configuration(self, changes):
        Client.is_updating = True
        if Client.block is not None:
            assert Client.block.wait(DEADLINE_S)
        if Client.fails_to_update is not None:
            error, Client.fails_to_update = Client.fails_to_update, None
            raise error
        Client.updates.append(changes)
        return {'a': 1, **changes, 'groups': {}}

    def close(self):
        Client.open_now -= 1


@pytest.fixture
def node(monkeypatch, wait_for_threads):
    """Tuning of a node that answers."""
    for name, value in (('opened', 0), ('open_now', 0), ('most_open', 0), ('updates', []),
                        ('descriptions', [{'name': 'a'}]), ('block', None), ('fails', 0),
                        ('fails_to_update', None), ('is_updating', False),
                        ('address', Client.address)):
        monkeypatch.setattr(Client, name, value)
    monkeypatch.setattr(tuning, 'Client', Client)
    monkeypatch.setattr(tuning.master, 'calls', lambda: argparse.Namespace(
        ask=lambda method, name: Client.address))
    monkeypatch.setattr(tuning, 'RETRY_PERIOD_S', 0.05)
    monkeypatch.setattr(tuning, 'CONNECT_TIMEOUT_S', 0.05)
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: False)
    parameters = Tuning('/color_extract')
    yield parameters
    parameters.watch('page', False)
    wait_for_threads()
    assert Client.open_now == 0


@pytest.fixture
def warnings(monkeypatch):
    """The warnings that are logged."""
    lines = []
    monkeypatch.setattr(rospy, 'logwarn', lambda text, *values: lines.append(text % values))
    return lines


def test_values_are_there_while_somebody_looks(node):
    assert node.values() == {}
    node.watch('page', True)
    revision = wait_for(lambda: node.values() == {'a': 1} and node.revision, 'the values')
    node.change(a=2)
    wait_for(lambda: node.values() == {'a': 2} and node.revision > revision, 'the change')
    assert Client.updates == [{'a': 2}]
    node.watch('other', True)
    node.watch('page', False)
    node.change(a=3)
    wait_for(lambda: node.values() == {'a': 3}, 'the change of the other page')
    node.watch('other', False)
    wait_for(lambda: node.values() == {}, 'the end')
    assert Client.open_now == 0


def test_a_node_that_does_not_answer_is_told_once_until_it_has_answered(node, warnings):
    Client.fails = 4
    node.watch('page', True)
    wait_for(node.values, 'the values')
    assert warnings == [
        'the parameters of /color_extract: timeout exceeded while waiting for service']
    Client.fails, Client.fails_to_update = 2, rospy.ROSException('gone')
    node.change(a=2)
    wait_for(lambda: node.values() == {'a': 2}, 'the change')
    assert warnings[1:] == ['the parameters of /color_extract: gone']


def test_a_node_that_is_not_there_is_no_reason_to_warn(node, warnings):
    Client.fails, Client.address = 3, None
    node.watch('page', True)
    wait_for(node.values, 'the values')
    assert warnings == []


def test_a_change_that_could_not_be_sent_is_forgotten_when_nobody_looks_any_more(
        node, wait_for_threads):
    Client.fails = 1000
    node.watch('page', True)
    wait_for(lambda: Client.fails < 1000, 'a try to connect')
    node.change(a=10)
    node.watch('page', False)
    wait_for_threads()
    Client.fails = 0
    node.watch('page', True)
    wait_for(lambda: node.values() == {'a': 1}, 'the values')
    node.change(b=3)
    wait_for(lambda: Client.updates, 'a change')
    assert Client.updates == [{'b': 3}]


def test_of_several_changes_that_wait_the_last_is_sent(node):
    Client.block = threading.Event()
    node.watch('page', True)
    wait_for(node.values, 'the values')
    node.change(a=2)
    wait_for(lambda: Client.is_updating, 'the first change to be taken')
    assert not node.is_settled()
    for value in (3, 4, 5):
        node.change(a=value, b=value)
    Client.block.set()
    wait_for(node.is_settled, 'the changes')
    assert Client.updates == [{'a': 2}, {'a': 5, 'b': 5}]
    assert node.values() == {'a': 5, 'b': 5}


def test_there_is_never_a_second_client(node):
    """rospy would not give it the latched messages."""
    for _ in range(20):
        node.watch('page', True)
        wait_for(node.values, 'the values')
        node.watch('page', False)
        node.watch('page', True)
    assert Client.most_open == 1


@pytest.mark.parametrize('problem', [{'fails': 3}, {'descriptions': None}])
def test_it_connects_again_until_the_node_answers(node, problem, warnings):
    for name, value in problem.items():
        setattr(Client, name, value)
    node.change(a=7)
    node.watch('page', True)
    wait_for(lambda: warnings, 'a warning')
    assert '/color_extract' in warnings[0]
    Client.descriptions = [{'name': 'a'}]
    wait_for(lambda: Client.updates == [{'a': 7}], 'the change')


@pytest.mark.parametrize('error', [DynamicReconfigureCallbackException('call failed'),
                                   rospy.ROSException('unavailable'), OSError('broken pipe')])
def test_a_change_whose_call_fails_is_sent_again(node, error):
    Client.fails_to_update = error
    node.watch('page', True)
    wait_for(node.values, 'the values')
    node.change(a=8)
    wait_for(lambda: Client.updates == [{'a': 8}], 'the change')
    assert Client.opened == 2
