"""Who drives, and until when."""
import threading
import time
from types import SimpleNamespace

import pytest

from img_recog.nodes.web import shown_robots
from img_recog.nodes.web.shown_robots import HOLD_S, Driving, Speeds, yield_services
from img_recog.ros import stopping_publisher
from img_recog.ros.timed_xmlrpc import SystemState
from img_recog.teleoperation import VelocityLimits
from img_recog_helpers.waiting import DEADLINE_S, wait_for


# each step: the time in HOLD_S, who, its linear speed or None for a release, whether that is
# accepted, and what drives the robot then
WHO_DRIVES = {
    'a command holds for a moment': [
        (0, 'page', 1, True, 1), (0.9, 'other', None, None, 1), (1, 'other', None, None, None)],
    'a release ends it at once, but only for its owner': [
        (0, 'page', 1, True, 1), (0, 'other', None, None, 1), (0, 'page', None, None, None)],
    'the first who holds drives until the end': [
        (0, 'page', 1, True, 1), (0, 'other', -1, False, 1), (1, 'third', -1, True, -1),
        (1, 'page', None, None, -1)],
    'who was refused does not drive until it has let go': [
        (0, 'page', 1, True, 1), (0, 'other', -1, False, 1), (2, 'other', -1, False, None),
        (2, 'page', 1, True, 1), (2, 'page', None, None, None), (2, 'other', -1, False, None),
        (2, 'other', None, None, None), (2, 'other', -1, True, -1)],
    'anybody can stop the robot': [
        (0, 'page', 1, True, 1), (0, 'other', 0, True, 0), (0, 'other', None, None, None),
        (0, 'page', 1, False, None), (0, 'page', None, None, None), (0, 'page', 1, True, 1)],
    'who was refused can stop the robot too': [
        (0, 'page', 1, True, 1), (0, 'other', -1, False, 1), (0, 'other', 0, True, 0),
        (0, 'other', -1, False, 0), (0, 'page', 1, False, 0), (0, 'other', None, None, None),
        (0, 'page', 1, False, None)],
    **{'who pauses does not drive again after another one: {}'.format(linear): [
        (0, 'page', 1, True, 1), (2, 'other', linear, True, linear),
        (2, 'other', None, None, None), (2, 'page', 1, False, None),
        (2, 'page', None, None, None), (2, 'page', 1, True, 1)] for linear in (0, -1)},
    'who pauses may go on if nobody else has driven': [
        (0, 'page', 1, True, 1), (2, 'other', None, None, None), (2, 'page', 1, True, 1)],
}


@pytest.mark.parametrize('steps', WHO_DRIVES.values(), ids=list(WHO_DRIVES))
def test_who_drives(steps):
    time_s = 0.0
    speeds = Speeds(lambda: time_s)
    assert speeds.current() is None
    for time_in_holds, owner, linear, is_accepted, driven in steps:
        time_s = time_in_holds * HOLD_S
        if linear is None:
            speeds.release(owner)
        else:
            assert speeds.hold(owner, linear, 0.5 * linear) is is_accepted
        assert speeds.current() == (None if driven is None else (driven, 0.5 * driven))


def test_the_services_of_other_publishers(monkeypatch):
    state = SystemState({'/cmd_vel': ['/web', '/teleop', '/foreign'], '/odom': ['/gazebo']}, {},
                        {'/teleop/yield': ['/teleop'], '/gazebo/yield': ['/gazebo'],
                         '/foreign/get_loggers': ['/foreign']})
    monkeypatch.setattr(shown_robots.rospy, 'get_name', lambda: '/web')
    monkeypatch.setattr(shown_robots.master_calls, 'calls',
                        lambda: SimpleNamespace(state=lambda: state))
    assert yield_services('/cmd_vel') == ['/teleop/yield']
    assert yield_services('/nobody') == []


@pytest.fixture
def node(monkeypatch, wait_for_threads):
    """A stand-in for the node: sent speeds, its shutdown hook, services that yield, who was asked.
    """
    found = SimpleNamespace(sent=[], hooks=[], services={}, asked=[], has_ended=False)
    monkeypatch.setattr(stopping_publisher, 'DirectPublisher', lambda *_: SimpleNamespace(
        publish=lambda msg: found.sent.append(msg.linear.x)))
    monkeypatch.setattr(stopping_publisher.lifecycle, 'on_shutdown', found.hooks.append)
    monkeypatch.setattr(shown_robots.rospy, 'is_shutdown', lambda: found.has_ended)
    monkeypatch.setattr(shown_robots, 'yield_services', lambda _: sorted(found.services))
    monkeypatch.setattr(shown_robots.rospy, 'ServiceProxy', lambda name, _: found.services[name])
    monkeypatch.setattr(shown_robots, 'YIELD_PERIOD_S', 0.01)
    monkeypatch.setattr(shown_robots, 'READ_PERIOD_S', 0.05)
    monkeypatch.setattr(shown_robots, 'POLL_PERIOD_S', 0.05)

    def answer(name):
        found.services[name] = lambda: found.asked.append(name) or SimpleNamespace(success=True)
    found.answer = answer
    yield found
    found.has_ended = True
    wait_for_threads()


def hold_until(driven, condition, what):
    """Hold as a page does, until a condition is true."""
    wait_for(lambda: driven.hold('page', 0.5, 0.0) and condition(), what)


def wait_for_the_end_of_a_hold():
    end_s = time.monotonic() + 2 * HOLD_S
    wait_for(lambda: time.monotonic() > end_s, 'the end of the hold')


def test_the_robot_is_stopped_when_the_node_ends_meanwhile(node):
    driven = Driving(VelocityLimits(), '/cmd_vel')
    hold_until(driven, lambda: node.sent and node.sent[-1] == 0.11, 'a command')
    node.hooks[0]()
    assert node.sent[-1] == 0.0
    count = len(node.sent)
    driven.hold('page', 1.0, 0.0)
    wait_for_the_end_of_a_hold()
    assert len(node.sent) == count


def test_nothing_is_sent_when_the_node_ends_and_nobody_drives(node):
    Driving(VelocityLimits(), '/cmd_vel')
    node.hooks[0]()
    assert node.sent == []


def test_who_is_refused_does_not_keep_the_other_nodes_from_driving(node):
    node.answer('/a/yield')
    driven = Driving(VelocityLimits(), '/cmd_vel')
    hold_until(driven, lambda: node.asked, 'the node to yield')
    assert not driven.hold('other', 1.0, 0.0)
    driven.release('page')
    wait_for(lambda: node.sent[-3:] == [0.0, 0.0, 0.0], 'the stop')
    wait_for_the_end_of_a_hold()
    node.sent.clear(), node.asked.clear()
    assert not driven.hold('other', 1.0, 0.0)
    wait_for_the_end_of_a_hold()
    assert node.sent == [] and node.asked == []
    driven.release('other')
    assert driven.hold('other', 1.0, 0.0)
    wait_for(lambda: node.asked and 0.22 in node.sent, 'the other one to drive')


def test_all_nodes_yield_also_those_that_start_meanwhile(node):
    hangs = threading.Event()

    def fail():
        raise RuntimeError('closed')
    node.services = {'/a/yield': lambda: hangs.wait(DEADLINE_S), '/b/yield': fail}
    node.answer('/c/yield')
    driven = Driving(VelocityLimits(), '/cmd_vel')
    hold_until(driven, lambda: node.asked.count('/c/yield') > 3, 'the answers')
    node.answer('/d/yield')
    hold_until(driven, lambda: '/d/yield' in node.asked, 'the node that has started')
    hangs.set()
