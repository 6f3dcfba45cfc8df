"""Who drives, and until when."""
import threading
from types import SimpleNamespace

import pytest

from img_recog.nodes.web import driving
from img_recog.nodes.web.driving import HOLD_S, Driving, Speeds, yield_services
from img_recog.ros import stopping_publisher
from img_recog.teleoperation.settings import VelocityLimits
from img_recog_testing.waiting import DEADLINE_S, wait_for


class Clock:
    time_s = 0.0

    def __call__(self):
        return self.time_s


def test_a_command_holds_for_a_moment():
    clock = Clock()
    speeds = Speeds(clock)
    assert speeds.current() is None
    assert speeds.hold('page', 1.0, -0.5)
    clock.time_s = HOLD_S * 0.9
    assert speeds.current() == (1.0, -0.5)
    clock.time_s = HOLD_S
    assert speeds.current() is None


def test_a_release_ends_it_at_once_but_only_for_its_owner():
    speeds = Speeds(Clock())
    speeds.hold('page', 1.0, 0.0)
    speeds.release('other')
    assert speeds.current() == (1.0, 0.0)
    speeds.release('page')
    assert speeds.current() is None


def test_the_first_who_holds_drives_until_the_end():
    clock = Clock()
    speeds = Speeds(clock)
    assert speeds.hold('page', 1.0, 0.0)
    assert not speeds.hold('other', -1.0, 0.0)
    assert speeds.current() == (1.0, 0.0)
    clock.time_s = HOLD_S
    assert speeds.hold('third', -1.0, 0.0)          # the first one has stopped sending
    speeds.release('page')
    assert speeds.current() == (-1.0, 0.0)


def test_who_was_refused_does_not_drive_until_it_has_let_go():
    clock = Clock()
    speeds = Speeds(clock)
    assert speeds.hold('page', 1.0, 0.0)
    assert not speeds.hold('other', -1.0, 0.0)
    clock.time_s = 2 * HOLD_S                       # the browser of the first one was busy
    assert speeds.current() is None
    assert not speeds.hold('other', -1.0, 0.0) and speeds.current() is None
    assert speeds.hold('page', 1.0, 0.0)
    speeds.release('page')
    assert not speeds.hold('other', -1.0, 0.0)
    speeds.release('other')
    assert speeds.hold('other', -1.0, 0.0)


def test_anybody_can_stop_the_robot():
    speeds = Speeds(Clock())
    assert speeds.hold('page', 1.0, 0.0)
    assert speeds.hold('other', 0.0, 0.0)
    assert speeds.current() == (0.0, 0.0)
    speeds.release('other')
    assert not speeds.hold('page', 1.0, 0.0) and speeds.current() is None
    speeds.release('page')
    assert speeds.hold('page', 1.0, 0.0)


def test_who_was_refused_can_stop_the_robot_too():
    speeds = Speeds(Clock())
    assert speeds.hold('page', 1.0, 0.0)
    assert not speeds.hold('other', -1.0, 0.0)
    assert speeds.hold('other', 0.0, 0.0) and speeds.current() == (0.0, 0.0)
    assert not speeds.hold('other', -1.0, 0.0) and not speeds.hold('page', 1.0, 0.0)
    assert speeds.current() == (0.0, 0.0)
    speeds.release('other')
    assert speeds.current() is None and not speeds.hold('page', 1.0, 0.0)


@pytest.mark.parametrize('linear', [0.0, -1.0])
def test_who_pauses_does_not_drive_again_after_another_one(linear):
    clock = Clock()
    speeds = Speeds(clock)
    assert speeds.hold('page', 1.0, 0.0)
    clock.time_s = 2 * HOLD_S           # its connection pauses
    assert speeds.current() is None
    assert speeds.hold('other', linear, 0.0)
    speeds.release('other')
    assert not speeds.hold('page', 1.0, 0.0) and speeds.current() is None
    speeds.release('page')
    assert speeds.hold('page', 1.0, 0.0)


def test_who_pauses_may_go_on_if_nobody_else_has_driven():
    clock = Clock()
    speeds = Speeds(clock)
    assert speeds.hold('page', 1.0, 0.0)
    clock.time_s = 2 * HOLD_S
    assert speeds.hold('page', 1.0, 0.0) and speeds.current() == (1.0, 0.0)


def test_the_services_of_other_publishers(monkeypatch):
    state = ([['/cmd_vel', ['/web', '/teleop', '/foreign']], ['/odom', ['/gazebo']]], [],
             [['/teleop/yield', ['/teleop']], ['/gazebo/yield', ['/gazebo']],
              ['/foreign/get_loggers', ['/foreign']]])
    monkeypatch.setattr(driving.rospy, 'get_name', lambda: '/web')
    monkeypatch.setattr(driving.master, 'system_state', lambda: state)
    assert yield_services('/cmd_vel') == ['/teleop/yield']
    assert yield_services('/nobody') == []


@pytest.fixture
def node(monkeypatch):
    """A stand-in for the node: sent speeds, its shutdown hook, and the services that yield."""
    found = SimpleNamespace(sent=[], hooks=[], services={}, has_ended=False)
    monkeypatch.setattr(stopping_publisher, 'DirectPublisher', lambda *_: SimpleNamespace(
        publish=lambda msg: found.sent.append(msg.linear.x)))
    monkeypatch.setattr(stopping_publisher.lifecycle, 'on_shutdown', found.hooks.append)
    monkeypatch.setattr(driving.rospy, 'is_shutdown', lambda: found.has_ended)
    monkeypatch.setattr(driving, 'yield_services', lambda _: sorted(found.services))
    monkeypatch.setattr(driving.rospy, 'ServiceProxy', lambda name, _: found.services[name])
    monkeypatch.setattr(driving, '_YIELD_PERIOD_S', 0.01)
    monkeypatch.setattr(driving, '_POLL_PERIOD_S', 0.05)
    before = set(threading.enumerate())
    yield found
    found.has_ended = True
    wait_for(lambda: set(threading.enumerate()) <= before, 'the end of the threads')


def test_the_robot_is_stopped_when_the_node_ends_meanwhile(node):
    driven = Driving(VelocityLimits(), '/cmd_vel')

    def drives():
        driven.hold('page', 0.5, 0.0)
        return node.sent and node.sent[-1] == 0.11
    wait_for(drives, 'a command')
    node.hooks[0]()
    assert node.sent[-1] == 0.0
    count = len(node.sent)
    driven.hold('page', 1.0, 0.0)
    wait_for(lambda: driven._speeds.current() is None, 'the end of the hold')
    assert len(node.sent) == count


def test_nothing_is_sent_when_the_node_ends_and_nobody_drives(node):
    Driving(VelocityLimits(), '/cmd_vel')
    node.hooks[0]()
    assert node.sent == []


def test_who_is_refused_does_not_keep_the_other_nodes_from_driving(node):
    driven = Driving(VelocityLimits(), '/cmd_vel')
    driven._speeds.hold('page', 1.0, 0.0)
    assert not driven.hold('other', 1.0, 0.0) and not driven._driven.is_set()
    driven._speeds.release('page')
    assert not driven.hold('other', 1.0, 0.0) and not driven._driven.is_set()
    driven.release('other')
    assert driven.hold('other', 1.0, 0.0) and driven._driven.is_set()


def test_nodes_that_start_meanwhile_yield_too(node, monkeypatch):
    monkeypatch.setattr(driving, '_READ_PERIOD_S', 0.05)
    asked = []

    def answer(name):
        return lambda: asked.append(name) or SimpleNamespace(success=True)
    node.services = {'/a/yield': answer('a')}
    driven = Driving(VelocityLimits(), '/cmd_vel')

    def hold(name):
        driven.hold('page', 1.0, 0.0)
        return name in asked
    wait_for(lambda: hold('a'), 'the first node to yield')
    node.services['/b/yield'] = answer('b')
    wait_for(lambda: hold('b'), 'the second node to yield')


def test_nodes_yield_although_another_one_does_not_answer(node):
    hangs, asked = threading.Event(), []

    def fail():
        raise RuntimeError('closed')
    node.services = {'/a/yield': lambda: hangs.wait(DEADLINE_S), '/b/yield': fail,
                     '/c/yield': lambda: asked.append(1) or SimpleNamespace(success=True)}
    driven = Driving(VelocityLimits(), '/cmd_vel')

    def hold():
        driven.hold('page', 1.0, 0.0)
        return len(asked) > 3
    wait_for(hold, 'the answers')
    hangs.set()
