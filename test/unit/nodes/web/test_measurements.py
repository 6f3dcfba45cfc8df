"""What pages get of the messages of topics, without a master."""
from types import SimpleNamespace

import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from nav_msgs.msg import Odometry
from rosgraph_msgs.msg import Log
from sensor_msgs.msg import LaserScan

from img_recog.nodes.web import log_tab, measurements, nodes_tab, updates
from img_recog.nodes.web.measurements import RobotMeasurements, SystemTopics
from img_recog.nodes.web.updates import Updates


def callbacks(topics):
    """Return the callbacks by the names of their topics."""
    return {name: callback for name, _, callback in topics}


def odometry(x, y):
    msg = Odometry()
    msg.pose.pose.position.x, msg.pose.pose.position.y = x, y
    msg.pose.pose.orientation.w = 1.0
    return msg


def test_places_of_the_robots_that_are_there(monkeypatch):
    monkeypatch.setattr(measurements, 'PLACES_PERIOD_S', 0.0)
    system = SystemTopics([])
    system.follow({'a': '/a/odom', 'b': '/b/odom'})
    place = callbacks(system.topics())
    place['/a/odom'](odometry(1.0, 2.0))
    place['/b/odom'](odometry(3.0, 4.0))
    assert system.updates.since(None)[1]['robots'] == {'a': [1.0, 2.0, 0.0], 'b': [3.0, 4.0, 0.0]}
    system.follow({'b': '/b/odom'})
    assert system.updates.since(None)[1]['robots'] == {'b': [3.0, 4.0, 0.0]}
    assert '/a/odom' not in callbacks(system.topics())


def test_the_topics_of_the_tabs_are_among_those_of_the_system():
    system = SystemTopics([log_tab.topics, nodes_tab.topics])
    assert set(callbacks(system.topics())) == {
        '/gazebo/real_time_factor', '/gazebo/world_outlines', '/rosout_agg', '/diagnostics'}
    callbacks(system.topics())['/rosout_agg'](Log(level=Log.WARN, name='/a', msg='hot'))
    assert system.updates.since(None)[1] == {'log': [[0.0, 'warn', '/a', 'hot']]}


@pytest.mark.parametrize('field', ['angle_min', 'angle_increment'])
@pytest.mark.parametrize('value', [float('nan'), float('inf')])
def test_a_scan_without_angles_is_dropped(field, value):
    robot = RobotMeasurements('/{}'.format)
    scanned = callbacks(robot.topics())['/scan']
    scanned(LaserScan(ranges=[1.0], range_max=2.0, **{field: value}))
    assert robot.updates.since(None)[1] == {}
    scanned(LaserScan(ranges=[1.0, float('nan')], range_max=2.0, angle_increment=0.5))
    assert robot.updates.since(None)[1]['scan'] == {
        'pose': None, 'angle_min': 0.0, 'angle_increment': 0.5, 'ranges': [1.0, None]}


def test_a_scan_has_the_pose_of_its_moment():
    robot = RobotMeasurements('/{}'.format)
    called = callbacks(robot.topics())
    for x in (1.0, 2.0):
        called['/odom'](odometry(x, 3.0))
        called['/scan'](LaserScan(ranges=[1.0], range_max=2.0))
    called['/odom'](odometry(4.0, 3.0))
    assert robot.updates.since(None)[1]['scan']['pose'] == [2.0, 3.0, 0.0]
    assert robot.updates.since(None)[1]['pose'] == [4.0, 3.0, 0.0]


@pytest.mark.parametrize('positions, path', [
    ((0.0, 0.01, 0.03, 0.04, 0.06, 0.4), [0.0, 0.03, 0.06, 0.4]),      # those that are apart
    ((0.0, 0.3, 0.31, 0.82, 0.2), [0.0, 0.3, None, 0.82, None, 0.2])])  # the robot was moved
def test_the_path(positions, path):
    robot = RobotMeasurements('/{}'.format)
    for x in positions:
        callbacks(robot.topics())['/odom'](odometry(x, 1.0))
    assert robot.updates.since(None)[1]['path'] == [x if x is None else (x, 1.0) for x in path]


def test_states_of_nodes_up_to_a_number(monkeypatch):
    monkeypatch.setattr(updates, 'MAX_STATES', 2)
    found = Updates()
    (_, _, diagnosed), = nodes_tab.topics(found)
    for name in ('a', 'b', 'c', 'a'):
        diagnosed(DiagnosticArray(status=[DiagnosticStatus(
            name=name, level=b'\1', message='slow', values=[KeyValue('rate (Hz)', '3')])]))
    states = found.since(None)[1]
    assert sorted(states) == ['node a', 'node b']
    del states['node a']['time_s']
    assert states['node a'] == {
        'name': 'a', 'level': 1, 'message': 'slow', 'values': [['rate (Hz)', '3']]}


def test_no_level_of_the_log_is_dropped_for_another(monkeypatch):
    found = Updates()
    monkeypatch.setattr(log_tab, 'time', SimpleNamespace(monotonic=lambda: 0.0))
    (_, _, logged), = log_tab.topics(found)
    levels = (Log.DEBUG, Log.INFO, Log.WARN, Log.ERROR, Log.FATAL)
    for level in levels:
        logged(Log(level=level, name='/a', msg='motor {}'.format(level)))
    for number in range(1000):
        logged(Log(level=Log.INFO, name='/a', msg='x' * number))
    lines = found.since(None)[1]['log']
    assert [line[1] for line in lines if 'motor' in line[3]] == ['debug', 'warn', 'error', 'fatal']
    # in the order in which they came
    assert [line[3] for line in lines[:2]] == ['motor 1', 'motor 4'] and len(lines) == 104


class Failing:
    """Stands in for rospy.Subscriber; failures: that are left, by topic; subscribed: the topics.
    """

    failures, subscribed = {}, set()

    def __init__(self, name, *_, **__):
        self.name = name
        self.fail()
        self.subscribed.add(name)

    def unregister(self):
        self.subscribed.remove(self.name)
        self.fail()

    def fail(self):
        self.failures[self.name] = self.failures.get(self.name, 0) - 1
        if self.failures[self.name] >= 0:
            raise RuntimeError('no socket is left')


def test_a_topic_that_cannot_be_subscribed_is_tried_again_and_ends_no_other(
        monkeypatch, wait_for_threads):
    warnings = []
    monkeypatch.setattr(measurements, 'RETRY_PERIOD_S', 0.01)
    monkeypatch.setattr(measurements, 'ThrottledWarning', lambda: lambda text, *values: (
        warnings.append(text % values)))
    monkeypatch.setattr(measurements.rospy, 'Subscriber', Failing)
    monkeypatch.setattr(measurements.rospy, 'is_shutdown', lambda: False)
    monkeypatch.setattr(Failing, 'failures', {'/odom': 2})
    monkeypatch.setattr(Failing, 'subscribed', set())
    robot = RobotMeasurements('/{}'.format)
    robot.watch(True)
    wait_for_threads()
    assert warnings == 2 * ['/odom: RuntimeError: no socket is left']
    assert Failing.subscribed == set(callbacks(robot.topics()))
    Failing.failures['/scan'] = 1
    robot.watch(False)
    wait_for_threads()
    assert not Failing.subscribed and warnings[2:] == ['/scan: RuntimeError: no socket is left']
    robot.watch(True)
    wait_for_threads()
    assert Failing.subscribed == set(callbacks(robot.topics()))


def test_log_lines_that_differ_only_in_numbers_are_sent_once_a_second(monkeypatch):
    found, times = Updates(), iter([0.0, 0.5, 0.6, 0.7, 1.1])
    monkeypatch.setattr(log_tab, 'time', SimpleNamespace(monotonic=lambda: next(times)))
    (_, _, logged), = log_tab.topics(found)
    for text in ('blue=1', 'blue=2', 'red=2', 'blue=3', 'blue=4'):
        logged(Log(level=Log.INFO, name='/a', msg=text))
    assert [line[3] for line in found.since(None)[1]['log']] == ['blue=1', 'red=2', 'blue=4']
