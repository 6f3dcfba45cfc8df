"""Parameters of another node, with stand-ins for its topic and its service."""
import threading

import pytest
import rospy
from dynamic_reconfigure.encoding import decode_config, encode_config
from dynamic_reconfigure.srv import ReconfigureResponse

from img_recog.nodes.web import tuning
from img_recog.nodes.web.tuning import Tuning
from img_recog_helpers.waiting import DEADLINE_S, wait_for


class Node:
    """What answers: `fails` are errors of the next calls, `block` holds the calls."""

    def __init__(self):
        self.values = {'b': 0, 'a': 1}
        self.listeners, self.updates, self.fails = [], [], []
        self.block, self.is_updating = None, False

    def subscriber(self, topic, _, callback, **__):
        assert topic == '/color_extract/parameter_updates'
        self.listeners.append(callback)
        callback(encode_config(self.values))
        return Subscription(lambda: self.listeners.remove(callback))

    def call(self, config):
        self.is_updating = True
        if self.block is not None:
            assert self.block.wait(DEADLINE_S)
        if self.fails:
            raise self.fails.pop()
        self.updates.append(dict(decode_config(config)))
        self.values.update(self.updates[-1])
        return ReconfigureResponse(encode_config(self.values))


class Subscription:
    def __init__(self, unregister):
        self.unregister = unregister


@pytest.fixture
def node(monkeypatch, wait_for_threads):
    made = Node()
    monkeypatch.setattr(rospy, 'Subscriber', made.subscriber)
    monkeypatch.setattr(rospy, 'ServiceProxy', lambda name, _: {
        '/color_extract/set_parameters': made.call}[name])
    monkeypatch.setattr(tuning, 'RETRY_PERIOD_S', 0.05)
    monkeypatch.setattr(rospy, 'is_shutdown', lambda: False)
    made.tuning = Tuning('/color_extract')
    yield made
    made.tuning.watch_for('page', False)
    wait_for_threads()
    assert made.listeners == []


@pytest.fixture
def warnings(monkeypatch):
    """The warnings that are logged."""
    lines = []
    monkeypatch.setattr(rospy, 'logwarn', lambda text, *values: lines.append(text % values))
    return lines


def test_values_are_there_while_somebody_looks(node):
    colors = node.tuning
    assert colors.values() == {}
    colors.watch_for('page', True)
    revision = wait_for(lambda: colors.values() == {'a': 1, 'b': 0} and colors.revision,
                        'the values')
    colors.change(a=2)
    wait_for(lambda: colors.values()['a'] == 2 and colors.revision > revision, 'the change')
    assert node.updates == [{'a': 2}]
    colors.watch_for('other', True)
    colors.watch_for('page', False)
    node.listeners[0](encode_config({'a': 3}))      # another one has changed it
    assert colors.values() == {'a': 3}
    colors.watch_for('other', False)
    wait_for(lambda: colors.values() == {}, 'the end')


GONE, REFUSED = rospy.ServiceException('gone'), rospy.ROSException('unavailable')


def test_a_change_whose_call_fails_is_sent_again_and_told_once_until_one_is_done(node, warnings):
    colors, node.fails = node.tuning, [OSError('broken pipe'), REFUSED, GONE]
    colors.watch_for('page', True)
    colors.change(a=8)
    wait_for(colors.is_settled, 'the change')
    assert node.updates == [{'a': 8}] and colors.values()['a'] == 8
    assert warnings == ['the parameters of /color_extract: gone']
    node.fails = [REFUSED]
    colors.change(a=9)
    wait_for(colors.is_settled, 'the change')
    assert warnings[1:] == ['the parameters of /color_extract: unavailable']


def test_a_change_that_could_not_be_sent_is_forgotten_when_nobody_looks_any_more(
        node, wait_for_threads, warnings):
    colors, node.fails = node.tuning, [GONE] * 1000
    colors.watch_for('page', True)
    colors.change(a=10)
    wait_for(lambda: len(node.fails) < 1000, 'a try')
    colors.watch_for('page', False)
    wait_for_threads()
    node.fails = []
    colors.watch_for('page', True)
    colors.change(b=3)
    wait_for(lambda: node.updates, 'a change')
    assert node.updates == [{'b': 3}] and len(warnings) == 1


def test_of_several_changes_that_wait_the_last_is_sent(node):
    colors, node.block = node.tuning, threading.Event()
    colors.change(a=2)
    wait_for(lambda: node.is_updating, 'the first change to be taken')
    assert not colors.is_settled()
    for value in (3, 4, 5):
        colors.change(a=value, b=value)
    node.block.set()
    wait_for(colors.is_settled, 'the changes')
    assert node.updates == [{'a': 2}, {'a': 5, 'b': 5}]
    assert colors.values() == {'a': 5, 'b': 5}
