"""Lines of one place, compared with those of rospy.loginfo."""
import io
import logging
import re
import time
from types import SimpleNamespace

import pytest
import rospy
from rosgraph.roslogging import RosStreamHandler
from rosgraph_msgs.msg import Log
from rospy.impl import rosout as rospy_rosout
from rospy.msg import serialize_message

from img_recog.ros.transport import rosout
from img_recog.ros.transport.rosout import RecurringLine

STAMP = r'\d{4}-\d\d-\d\d \d\d:\d\d:\d\d,\d{3}'


class Setup:
    """The handlers of a node, whose file is `path` and whose /rosout is `sent`."""

    def __init__(self, path):
        self.path, self.sent = path, []
        self.terminal = io.StringIO()
        self.file = logging.FileHandler(str(path))
        self.file.setFormatter(logging.Formatter(
            '[%(name)s][%(levelname)s] %(asctime)s: %(message)s'))
        self.topic = rospy_rosout.RosOutHandler()
        self.screen = RosStreamHandler(False, self.terminal, self.terminal)

    def publish(self, msg):
        buffer = io.BytesIO()
        serialize_message(buffer, 3, msg)
        self.sent.append(Log().deserialize(buffer.getvalue()[4:]))

    def written(self):
        """Return what is in the file."""
        return self.path.read_text()


@pytest.fixture
def setup(tmp_path, monkeypatch):
    for name in ('get_param', 'get_param_cached'):
        monkeypatch.setattr(rospy, name, lambda name, default: default)
    monkeypatch.setattr(rospy_rosout.Time, 'now', lambda: rospy.Time(5, 7))
    made = Setup(tmp_path / 'node.log')
    monkeypatch.setattr(rospy_rosout, '_rosout_pub', made)
    monkeypatch.setattr(logging.getLogger(), 'handlers', [made.file])
    logger = logging.getLogger('rosout')
    level = logger.level
    monkeypatch.setattr(logger, 'handlers', [made.screen, made.topic])
    logger.setLevel(logging.INFO)
    yield made
    made.file.close()
    logger.setLevel(level)


class Node:
    """Something that logs."""

    def __init__(self):
        self.line = RecurringLine()
        logging.getLogger().handlers[1:] = []       # pytest's

    def handle(self, text, on_terminal=False):
        self.line.take_time()
        self.line.write(text, on_terminal)

    def write(self, text):
        self.line.write(text)

    def log(self, text):
        rospy.loginfo('%s', text)


@pytest.mark.parametrize('text', ['blue=12, red=3', '100 %', '%s %d', 'Größe 青', 'two\nlines', ''])
def test_lines_are_those_of_loginfo_but_not_on_the_terminal(setup, text):
    node = Node()
    node.handle('first')
    node.handle(text)
    assert setup.terminal.getvalue() == ''
    first, second = re.fullmatch(r'(\[.*: first\n)(\[.*)', setup.written(), re.DOTALL).groups()
    node.log(text)
    third = setup.written()[len(first + second):]
    assert re.sub(STAMP, '', second) == re.sub(STAMP, '', third) != second
    _, ours, theirs = setup.sent
    assert (ours.function, ours.file) == ('Node.handle', 'test_recurring_line.py')
    theirs.function, theirs.line = ours.function, ours.line
    assert ours == theirs and ours.header.stamp == rospy.Time(5, 7) and ours.header.seq == 3


def test_a_line_for_the_terminal_is_sent_once(setup):
    Node().handle('a line', on_terminal=True)
    assert [msg.msg for msg in setup.sent] == ['a line']
    assert setup.written().endswith(': a line\n')
    assert re.fullmatch(r'\[INFO\] \[[0-9.]+(, [0-9.]+)?\]: a line\n', setup.terminal.getvalue())


def test_a_line_has_the_time_that_was_taken(setup, monkeypatch):
    node = Node()
    node.line.take_time()
    taken = time.time()
    monkeypatch.setattr(rospy_rosout.Time, 'now', lambda: rospy.Time(6, 0))
    monkeypatch.setattr(rosout.time, 'time', lambda: taken + 100.0)
    node.write('a line')
    assert setup.sent[0].header.stamp == rospy.Time(5, 7)
    assert abs(time.mktime(time.strptime(
        re.search(STAMP, setup.written()).group()[:19], '%Y-%m-%d %H:%M:%S')) - taken) < 3


def test_the_time_is_that_of_the_line(setup, monkeypatch):
    node = Node()
    for now_s in (1e9, 1e9 + 0.9999, 1e9 + 1.25):
        monkeypatch.setattr(rosout.time, 'time', lambda now_s=now_s: now_s)
        # logging asks this from Python 3.13 on
        monkeypatch.setattr(rosout.time, 'time_ns', lambda now_s=now_s: round(1e9 * now_s))
        node.handle('a line')
        node.log('a line')
    lines = setup.written().splitlines()
    assert len(lines) == 6 and lines[::2] == lines[1::2]
    assert [line[-11:-8] for line in lines[::2]] == ['000', '999', '250']


@pytest.mark.parametrize('change, file, topic', [
    (lambda setup: setup.file.setLevel(logging.WARNING), False, True),
    (lambda setup: setup.file.addFilter(lambda record: False), False, True),
    (lambda setup: logging.getLogger('rosout').setLevel(logging.WARNING), False, False)])
def test_levels_and_filters_hold(setup, change, file, topic):
    node = Node()
    node.handle('first')
    change(setup)
    node.handle('second')
    assert ('second' in setup.written(), 'second' in [msg.msg for msg in setup.sent]) == (
        file, topic)


def test_a_closed_topic_does_not_reach_the_caller(setup, monkeypatch):
    def refuse(_):
        raise rospy.ROSException('closed')
    monkeypatch.setattr(setup, 'publish', refuse)
    Node().handle('a line')
    assert 'a line' in setup.written()


def test_topics_are_those_of_the_node_now_and_left_out_on_request(setup, monkeypatch):
    manager = SimpleNamespace(get_topics=lambda: manager.topics, topics=['/cmd_vel'])
    monkeypatch.setattr(rosout.registration, 'get_topic_manager', lambda: manager)
    node = Node()
    monkeypatch.setattr(rospy, 'get_param', lambda name, default: True)
    other = Node()
    for topics in (['/cmd_vel'], ['/cmd_vel', '/rosout'], []):
        manager.topics = topics
        node.handle('named')
        other.handle('not named')
    assert [(msg.msg, msg.topics) for msg in setup.sent] == [
        ('named', ['/cmd_vel']), ('not named', []), ('named', ['/cmd_vel', '/rosout']),
        ('not named', []), ('named', []), ('not named', [])]
