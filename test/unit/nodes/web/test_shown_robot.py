"""The pictures of a robot, without a master."""
import xmlrpc.client

import pytest
import rospy

from img_recog.nodes.web import shown_robot
from img_recog.nodes.web.measurements import SystemTopics
from img_recog.nodes.web.pictures import PictureTopics
from img_recog.nodes.web.shown_robot import ShownRobot
from img_recog.teleoperation.teleop_settings import VelocityLimits


@pytest.fixture
def robot(monkeypatch):
    """A robot of a master without topics; `warnings` are those that it has logged."""
    for name in ('Driving', 'PosePublisher'):
        monkeypatch.setattr(shown_robot, name, lambda *_: None)
    monkeypatch.setattr(rospy, 'get_published_topics', lambda: [])
    warnings = []
    monkeypatch.setattr(shown_robot, 'ThrottledWarning', lambda: lambda text, *values: (
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
