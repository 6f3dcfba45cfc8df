"""Log lines as messages on /rosout, from rospy's handler and from ours."""
import logging
from types import SimpleNamespace

import pytest
import rospy
from rosgraph_msgs.msg import Log
from rospy.impl import rosout as rospy_rosout

from img_recog.ros.transport import rosout


@pytest.fixture
def init_node(way, monkeypatch):
    """A function that calls rosout.init_node without a master."""
    for name in ('Publisher', 'RosOutHandler', '_rosout_pub'):
        monkeypatch.setattr(rospy_rosout, name, getattr(rospy_rosout, name))
    monkeypatch.setattr(rospy, 'init_node', lambda *args, **options: rospy_rosout.init_rosout())
    monkeypatch.setattr(rosout.parameters, 'log_topics_are_wanted', lambda: True)
    monkeypatch.setattr(rospy, 'get_param_cached', lambda name, default: default)
    return lambda: rosout.init_node('node')


@pytest.fixture
def logger(init_node, monkeypatch):
    """A logger whose lines go to /rosout."""
    init_node()
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time(5, 7))
    logger = logging.getLogger('to /rosout')
    logger.propagate = False
    handler = rospy_rosout.RosOutHandler()
    logger.addHandler(handler)
    yield logger
    logger.removeHandler(handler)


@pytest.fixture
def sent(logger, monkeypatch):
    """The messages that are published."""
    messages = []
    monkeypatch.setattr(rospy_rosout, '_rosout_pub', SimpleNamespace(publish=messages.append))
    return messages


def test_the_publisher_is_latched(way, init_node):
    init_node()
    assert rospy.topics.get_topic_manager().get_publisher_impl('/rosout').is_latch


@pytest.mark.parametrize('level, expected', [
    (logging.DEBUG, Log.DEBUG), (logging.INFO, Log.INFO), (logging.WARNING, Log.WARN),
    (logging.ERROR, Log.ERROR), (logging.CRITICAL, Log.FATAL)])
def test_the_message_of_a_line(logger, sent, level, expected):
    logger.handle(logging.LogRecord('rosout', level, '/some/node.py', 12, '%d%% of it', (7,), None,
                                    'Node.handle'))
    msg, = sent
    assert (msg.level, msg.msg, msg.name) == (expected, '7% of it', rospy.get_name())
    assert (msg.file, msg.line, msg.function) == ('node.py', 12, 'Node.handle')
    assert msg.header.stamp == rospy.Time(5, 7)
    assert set(msg.topics) == rospy.topics.get_topic_manager().get_topics()


def test_topics_are_omitted_on_request(logger, sent, monkeypatch):
    monkeypatch.setattr(rosout.parameters, 'log_topics_are_wanted', lambda: False)
    monkeypatch.setattr(rospy, 'get_param_cached', lambda name, default: True)
    logger.error('a line')
    assert len(sent) == 1 and not sent[0].topics


@pytest.mark.parametrize('error', [ConnectionRefusedError('no master'), UnicodeError('text'),
                                   rospy.ROSException('closed')])
def test_an_error_in_publishing_does_not_reach_the_caller(logger, monkeypatch, error):
    def refuse(_):
        raise error
    monkeypatch.setattr(rospy_rosout, '_rosout_pub', SimpleNamespace(publish=refuse))
    for _ in range(2):
        logger.error('a line')


def test_what_is_logged_while_publishing_is_not_published(logger, monkeypatch):
    messages = []

    def publish(msg):
        messages.append(msg.msg)
        logger.error('within')
    monkeypatch.setattr(rospy_rosout, '_rosout_pub', SimpleNamespace(publish=publish))
    logger.error('first')
    logger.error('second')
    assert messages == ['first', 'second']
