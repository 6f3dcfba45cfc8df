"""Which robots the page finds, and the pictures of one, without a master."""
import xmlrpc.client
from types import SimpleNamespace

import pytest
import rospy

from img_recog.nodes.web import shown_robots
from img_recog.nodes.web.measurements import SystemTopics
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.shown_robots import ShownRobot, ShownRobots, names_in
from img_recog.ros.timed_xmlrpc import SystemState
from img_recog.teleoperation import VelocityLimits

WEB = '/web'


def users(*rows):
    """Return topics with their nodes, of rows TOPIC NODE."""
    found = {}
    for row in rows:
        topic, node = row.split()
        found.setdefault(topic, []).append(node)
    return found


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
    # and only those in the namespace of the node
    published, subscribed = (['/lab' + row for row in rows] for rows in (published, subscribed))
    subscribed.append('/z/cmd_vel /x')
    assert names_in(users(*published), users(*subscribed), '/lab/', WEB) == names


def test_the_robots_stay_while_a_new_master_knows_none(monkeypatch):
    monkeypatch.setattr(shown_robots.rospy, 'get_namespace', lambda: '/')
    monkeypatch.setattr(shown_robots.rospy, 'get_name', lambda: WEB)
    found = ShownRobots(VelocityLimits(), PictureTopics(), SystemTopics([]))
    assert found.names == ['']
    for subscribed, names in ((['/a/cmd_vel /x', '/b/cmd_vel /x'], ['a', 'b']), ([], ['a', 'b']),
                              (['/b/cmd_vel /x'], ['b'])):
        monkeypatch.setattr(shown_robots.master_calls, 'calls', lambda: SimpleNamespace(
            state=lambda: SystemState({}, users(*subscribed), {})))
        found.update()
        assert found.names == names

    def fail():
        raise ConnectionRefusedError
    monkeypatch.setattr(shown_robots.master_calls, 'calls', fail)
    found.update()
    assert found.names == ['b']


@pytest.fixture
def robot(monkeypatch):
    """A robot of a master without topics; `warnings` are those that it has logged."""
    for name in ('Driving', 'PosePublisher'):
        monkeypatch.setattr(shown_robots, name, lambda *_: None)
    monkeypatch.setattr(rospy, 'get_published_topics', lambda: [])
    warnings = []
    monkeypatch.setattr(shown_robots, 'ThrottledWarning', lambda: lambda text, *values: (
        warnings.append(text % values)))
    found = ShownRobot('tb3', VelocityLimits(), PictureTopics(), SystemTopics([]))
    found.warnings = warnings
    return found


def masks(robot):
    return {each.color: each.topic for each in robot.picture_topics() if each.title == 'mask'}


@pytest.mark.parametrize('given, expected', [
    (None, {'blue': '/tb3/blue_image', 'red': '/tb3/red_image'}),
    ({'colors': ['a', 'b'], 'b_image_topic': '/seen'}, {'a': '/tb3/a_image', 'b': '/seen'})])
def test_the_masks_of_the_colors(robot, monkeypatch, given, expected):
    monkeypatch.setattr(rospy, 'get_param', lambda name, default: given or default)
    assert masks(robot) == expected and robot.warnings == []


@pytest.mark.parametrize('error', [
    xmlrpc.client.Fault(1, 'int exceeds XML-RPC limits'), ConnectionRefusedError('refused')])
def test_parameters_that_the_master_does_not_send_leave_the_usual_colors(
        robot, monkeypatch, error):
    def fail(*_):
        raise error
    monkeypatch.setattr(rospy, 'get_param', fail)
    assert masks(robot) == {'blue': '/tb3/blue_image', 'red': '/tb3/red_image'}
    line, = robot.warnings
    assert line.startswith('the colors of color_extract: ') and (
        str(getattr(error, 'faultString', error)) in line)
