"""Which robots the page finds, and what their pages share."""
import pytest
from nav_msgs.msg import Odometry

from img_recog.nodes.web import measurements
from img_recog.nodes.web.measurements import Measurements, SystemTopics
from img_recog.nodes.web.news import News
from img_recog.nodes.web.robots import names_in

WEB = '/web'


def users(*rows):
    """Return a list of topics with their nodes, as the master does, of rows TOPIC NODE."""
    found = {}
    for row in rows:
        topic, node = row.split()
        found.setdefault(topic, []).append(node)
    return list(found.items())


@pytest.mark.parametrize('published, subscribed, names', [
    ([], [], ['']),
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
    (['/a/cmd_vel /web'], ['/a/cmd_vel /web'], ['']),
    (['/a/cmd_vel /web'], ['/b/cmd_vel /web', '/b/cmd_vel /base'], ['b']),
    ([], ['/lab/a/cmd_vel /x', '/my_cmd_vel /x', '/odom /x'], ['lab/a']),
    ([], ['/<script>/cmd_vel /x'], [''])])
def test_robots_are_found_by_who_takes_commands(published, subscribed, names):
    assert names_in(users(*published), users(*subscribed), '/', WEB) == names


def test_only_the_robots_in_the_namespace_of_the_node_are_found():
    subscribed = users('/lab/a/cmd_vel /x', '/b/cmd_vel /x')
    assert names_in([], subscribed, '/lab/', '/lab/web') == ['a']


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
