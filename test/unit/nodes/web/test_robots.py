"""Which robots the page finds, and what their pages share."""
import pytest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from nav_msgs.msg import Odometry
from sensor_msgs.msg import LaserScan

from img_recog.nodes.web import measurements, robots
from img_recog.nodes.web.measurements import Measurements, RobotTopics, SystemTopics
from img_recog.nodes.web.news import News
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.robots import Robots, names_in
from img_recog.teleoperation.settings import VelocityLimits

WEB = '/web'


def users(*rows):
    """Return a list of topics with their nodes, as the master does, of rows TOPIC NODE."""
    found = {}
    for row in rows:
        topic, node = row.split()
        found.setdefault(topic, []).append(node)
    return list(found.items())


@pytest.mark.parametrize('published, subscribed, names', [
    ([], [], []),
    (['/cmd_vel /color_extract', '/odom /gazebo'], ['/cmd_vel /gazebo'], ['']),
    # in the order of their numbers
    (['/tb3_10/odom /gazebo', '/tb3_9/odom /gazebo'],
     ['/tb3_10/cmd_vel /gazebo', '/tb3_9/cmd_vel /gazebo'], ['tb3_9', 'tb3_10']),
    # a recording or an echo, and a robot that is gone
    (['/a/odom /gazebo'], ['/a/cmd_vel /gazebo', '/cmd_vel /record', '/b/cmd_vel /echo'], ['a']),
    # a teleop without a robot
    (['/cmd_vel /teleop'], ['/a/cmd_vel /gazebo'], ['a']),
    (['/a/cmd_vel /teleop'], [], ['a']),
    # what the page itself has advertised or subscribes to is no robot
    (['/a/cmd_vel /web'], ['/a/cmd_vel /web'], []),
    (['/a/cmd_vel /web'], ['/b/cmd_vel /web', '/b/cmd_vel /base'], ['b']),
    ([], ['/lab/a/cmd_vel /x', '/my_cmd_vel /x', '/odom /x'], ['lab/a']),
    ([], ['/<script>/cmd_vel /x'], [])])
def test_robots_are_found_by_who_takes_commands(published, subscribed, names):
    assert names_in(users(*published), users(*subscribed), '/', WEB) == names


def test_only_the_robots_in_the_namespace_of_the_node_are_found():
    subscribed = users('/lab/a/cmd_vel /x', '/b/cmd_vel /x')
    assert names_in([], subscribed, '/lab/', '/lab/web') == ['a']


def test_the_robots_stay_while_a_new_master_knows_none(monkeypatch):
    monkeypatch.setattr(robots.rospy, 'get_namespace', lambda: '/')
    monkeypatch.setattr(robots.rospy, 'get_name', lambda: WEB)
    found = Robots(VelocityLimits(), PictureTopics(100))
    assert found.names == ['']
    for subscribed, names in ((['/a/cmd_vel /x', '/b/cmd_vel /x'], ['a', 'b']), ([], ['a', 'b']),
                              (['/b/cmd_vel /x'], ['b'])):
        monkeypatch.setattr(robots.master, 'system_state', lambda: (
            [], users(*subscribed), []))
        found.update()
        assert found.names == names

    def fail():
        raise robots.master.MasterError('no master answers')
    monkeypatch.setattr(robots.master, 'system_state', fail)
    found.update()
    assert found.names == ['b']


class Topics:
    def __init__(self):
        self.news, self.is_watched = News(), False

    def watch(self, is_watched):
        self.is_watched = is_watched


def test_the_topics_of_the_system_are_shared():
    system, one, two = Topics(), Topics(), Topics()
    watched = []
    first, second = Measurements(system, one, watched), Measurements(system, two, watched)
    for each in (first, first, second):
        each.watch(True)
    first.watch(False)
    assert (system.is_watched, one.is_watched, two.is_watched) == (True, False, True)
    second.watch(False)
    assert not system.is_watched and not two.is_watched


def test_a_page_gets_the_news_of_its_robot_and_of_the_system():
    system, robot = Topics(), Topics()
    shown = Measurements(system, robot, [])
    system.news.set('factor', 1.0)
    robot.news.set('pose', [0, 0, 0])
    cursor, news = shown.since(None)
    assert news == {'factor': 1.0, 'pose': [0, 0, 0]}
    system.news.set('factor', 2.0)
    cursor, news = shown.since(cursor)
    assert news == {'factor': 2.0}
    assert shown.since(cursor)[1] == {}


def odometry(x, y):
    msg = Odometry()
    msg.pose.pose.position.x, msg.pose.pose.position.y = x, y
    msg.pose.pose.orientation.w = 1.0
    return msg


def test_places_of_the_robots_that_are_there(monkeypatch):
    monkeypatch.setattr(measurements, '_PLACES_PERIOD_S', 0.0)
    system = SystemTopics()
    system.follow({'a': '/a/odom', 'b': '/b/odom'})
    place = {topic: callback for topic, _, callback in system._topics()}
    place['/a/odom'](odometry(1.0, 2.0))
    place['/b/odom'](odometry(3.0, 4.0))
    assert system.news.since(None)[1]['robots'] == {'a': [1.0, 2.0, 0.0], 'b': [3.0, 4.0, 0.0]}
    system.follow({'b': '/b/odom'})
    assert system.news.since(None)[1]['robots'] == {'b': [3.0, 4.0, 0.0]}
    assert '/a/odom' not in [topic for topic, _, _ in system._topics()]


@pytest.mark.parametrize('field', ['angle_min', 'angle_increment'])
@pytest.mark.parametrize('value', [float('nan'), float('inf')])
def test_a_scan_without_angles_is_dropped(field, value):
    robot = RobotTopics('/{}'.format)
    robot._scanned(LaserScan(ranges=[1.0], range_max=2.0, **{field: value}))
    assert robot.news.since(None)[1] == {}
    robot._scanned(LaserScan(ranges=[1.0, float('nan')], range_max=2.0, angle_increment=0.5))
    assert robot.news.since(None)[1]['scan'] == {
        'pose': None, 'angle_min': 0.0, 'angle_increment': 0.5, 'ranges': [1.0, None]}


def test_a_scan_has_the_pose_of_its_moment():
    robot = RobotTopics('/{}'.format)
    for x in (1.0, 2.0):
        robot._driven(odometry(x, 3.0))
        robot._scanned(LaserScan(ranges=[1.0], range_max=2.0))
    robot._driven(odometry(4.0, 3.0))
    assert robot.news.since(None)[1]['scan']['pose'] == [2.0, 3.0, 0.0]
    assert robot.news.since(None)[1]['pose'] == [4.0, 3.0, 0.0]


def test_the_number_of_states_is_limited(monkeypatch):
    monkeypatch.setattr(measurements, '_MAX_STATUSES', 2)
    system = SystemTopics()
    for name in ('a', 'b', 'c', 'a'):
        system._diagnosed(DiagnosticArray(status=[DiagnosticStatus(name=name, level=b'\0')]))
    assert sorted(system.news.since(None)[1]) == ['node a', 'node b']
