"""Lines of one place, compared with those of rospy.loginfo."""
import io
import logging
import re
from logging.handlers import RotatingFileHandler
from types import SimpleNamespace

import pytest
import rospy
from rosgraph.roslogging import RosStreamHandler
from rosgraph_msgs.msg import Log
from rospy.impl import rosout as rospy_rosout
from rospy.msg import serialize_message

from img_recog.ros.log import log_handlers
from img_recog.ros.transport import rosout
from img_recog.ros.transport.rosout import RecurringLine

FORMAT = '[%(name)s][%(levelname)s] %(asctime)s: %(message)s'
TEXTS = ['blue=12, red=3', '100 %', '%s %d', 'Größe 青', 'two\nlines', '']


class Setup:
    """The handlers of a node, whose file is `path` and whose /rosout is `sent`."""

    def __init__(self, path):
        self.path, self.sent = path, []
        self.terminal = io.StringIO()
        self.file = RotatingFileHandler(str(path), 'a', 50000000, 4)
        self.file.setFormatter(logging.Formatter(FORMAT))
        self.topic = rosout.RosoutHandler()
        self.screen = RosStreamHandler(False, self.terminal, self.terminal)

    def publish(self, msg):
        buffer = io.BytesIO()
        serialize_message(buffer, 3, msg)
        self.sent.append(Log().deserialize(buffer.getvalue()[4:]))

    def node(self):
        """Return a node; from now on, only the handlers of a node are used, not pytest's."""
        logging.getLogger().handlers[:] = [self.file]
        return Node()

    def written(self):
        """Return what is in the file."""
        return self.path.read_text()


@pytest.fixture
def setup(tmp_path, monkeypatch):
    monkeypatch.delenv('ROS_PYTHON_LOG_CONFIG_FILE', raising=False)
    monkeypatch.setattr(rosout.parameters, 'log_topics_are_wanted', lambda: False)
    monkeypatch.setattr(rospy.Time, 'now', lambda: rospy.Time(5, 7))
    made = Setup(tmp_path / 'node.log')
    monkeypatch.setattr(rospy_rosout, '_rosout_pub', made)
    monkeypatch.setattr(logging.getLogger(), 'handlers', [made.file])
    logger = logging.getLogger('rosout')
    level = logger.level
    for name, value in (('handlers', [made.screen, made.topic]), ('propagate', True)):
        monkeypatch.setattr(logger, name, value)
    logger.setLevel(logging.INFO)
    log_handlers.protect()
    yield made
    made.file.close()
    logger.setLevel(level)


class Node:
    """Something that logs."""

    def __init__(self):
        self.line = RecurringLine()

    def handle(self, text):
        return self.line.write(text)

    def log(self, text):
        rospy.loginfo('%s', text)


@pytest.mark.parametrize('text', TEXTS)
def test_lines_are_those_of_loginfo(setup, text):
    node = setup.node()
    assert node.handle('first') and node.handle(text)
    lines = setup.written()
    node.log(text)
    assert setup.terminal.getvalue().count('\n') == text.count('\n') + 1       # of loginfo only
    stamp = r'\d{4}-\d\d-\d\d \d\d:\d\d:\d\d,\d{3}'
    assert re.fullmatch(r'\[rosout\]\[INFO\] {}: first\n\[rosout\]\[INFO\] {}: {}\n'.format(
        stamp, stamp, re.escape(text)), lines)
    expected = setup.written()[len(lines):]
    assert re.sub(stamp, '', lines[lines.index('\n') + 1:]) == re.sub(stamp, '', expected)
    _, ours, theirs = setup.sent
    assert (ours.function, ours.file) == ('Node.handle', 'test_recurring_line.py')
    theirs.function, theirs.line = ours.function, ours.line
    assert ours == theirs and ours.header.stamp == rospy.Time(5, 7) and ours.header.seq == 3


def test_the_time_is_that_of_the_line(setup, monkeypatch):
    node = setup.node()
    for now_s in (1e9, 1e9 + 0.9999, 1e9 + 1.25):
        monkeypatch.setattr(rosout.time, 'time', lambda now_s=now_s: now_s)
        assert node.handle('a line')
        node.log('a line')
    lines = setup.written().splitlines()
    assert len(lines) == 6 and lines[::2] == lines[1::2]
    assert [line[-11:-8] for line in lines[::2]] == ['000', '999', '250']


OTHER_FORMATTER = type('Other', (logging.Formatter,), {})
UNUSUAL = {
    'another handler': lambda _: logging.getLogger('rosout').addHandler(logging.NullHandler()),
    'a second file': lambda _: logging.getLogger().addHandler(logging.NullHandler()),
    'no file': lambda _: logging.getLogger().handlers.clear(),
    'no topic': lambda setup: logging.getLogger('rosout').removeHandler(setup.topic),
    'a format': lambda setup: setup.file.setFormatter(logging.Formatter('%(message)s')),
    'a format of times': lambda setup: setup.file.setFormatter(logging.Formatter(FORMAT, '%H')),
    'a formatter': lambda setup: setup.file.setFormatter(OTHER_FORMATTER(FORMAT)),
    'a filter': lambda setup: setup.file.addFilter(lambda record: False),
    'few in the file': lambda setup: setup.file.setLevel(logging.WARNING),
    'few on the topic': lambda setup: setup.topic.setLevel(logging.WARNING),
    'not in the file': lambda _: setattr(logging.getLogger('rosout'), 'propagate', False)}


@pytest.mark.parametrize('change', UNUSUAL.values(), ids=list(UNUSUAL))
def test_an_unusual_log_is_left_to_loginfo(setup, change):
    node = setup.node()
    change(setup)
    assert not node.handle('a line')
    assert not setup.sent and not setup.written()


def test_the_topics_of_the_node_are_named(setup, monkeypatch):
    monkeypatch.setattr(rosout.parameters, 'log_topics_are_wanted', lambda: True)
    topics = {'/cmd_vel'}
    monkeypatch.setattr(rosout.registration, 'get_topic_manager',
                        lambda: SimpleNamespace(get_topics=lambda: topics))
    node = setup.node()
    for new in ('/cmd_vel', '/blue_image', '/blue_image', '/red_image'):
        topics.add(new)
        assert node.handle('a line')
        node.log('a line')
    assert [len(msg.topics) for msg in setup.sent] == [1, 1, 2, 2, 2, 2, 3, 3]
    assert set(setup.sent[-1].topics) == set(setup.sent[-2].topics) == topics


def test_handlers_that_come_and_go_are_noticed(setup):
    node, other = setup.node(), logging.NullHandler()
    assert node.handle('first')
    logging.getLogger('rosout').handlers.append(other)
    assert not node.handle('second')
    logging.getLogger('rosout').handlers.remove(other)
    assert node.handle('third')
    assert [msg.msg for msg in setup.sent] == ['first', 'third']


def test_a_level_above_info_hides_the_lines(setup):
    logging.getLogger('rosout').setLevel(logging.WARNING)
    assert setup.node().handle('a line')
    assert not setup.sent and not setup.written()


def test_a_full_file_is_replaced(setup):
    """Its size is checked every 100 lines."""
    setup.path.write_bytes(b'x' * 10000000)
    node = setup.node()
    assert node.handle('first')
    with setup.path.open('ab') as file:
        file.write(b'y' * 10000000)
    for number in range(100):
        assert node.handle('line {}'.format(number))
    assert setup.written().endswith(': line 99\n') and setup.written().count('\n') == 1
    first, second = (setup.path.with_name('node.log.' + end).read_bytes() for end in '21')
    assert first == b'x' * 10000000 and second.count(b'\n') == 100 and b': first\n' in second


def test_a_file_that_could_not_be_opened_is_opened_for_the_next_line(setup):
    node = setup.node()
    assert node.handle('first')
    setup.file.close()
    setup.file.stream = None        # as after a change of files that failed
    assert node.handle('second')
    assert [line[-6:].strip() for line in setup.written().splitlines()] == ['first', 'second']


def test_a_full_disk_is_said_once(setup, capfd):
    full = RotatingFileHandler('/dev/full', 'a', 50000000, 4)
    full.setFormatter(logging.Formatter(FORMAT))
    node = setup.node()
    logging.getLogger().handlers[:] = [full]
    log_handlers.protect()
    for number in range(9):
        assert node.handle(str(number))
    assert capfd.readouterr().err.count('cannot write to /dev/full: No space left on device') == 1
    assert [msg.msg for msg in setup.sent] == list('012345678')


def test_a_closed_topic_does_not_reach_the_caller(setup, monkeypatch):
    def refuse(_):
        raise rospy.ROSException('closed')
    monkeypatch.setattr(rospy_rosout, '_rosout_pub', SimpleNamespace(publish=refuse))
    assert setup.node().handle('a line') and 'a line' in setup.written()
