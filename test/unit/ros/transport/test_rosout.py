"""Lines of a node as Python's logging and rospy have them."""
import logging
import logging.handlers
import os
import time
from types import SimpleNamespace

import pytest
import rospy

from img_recog.ros.transport import rosout


class Kept(logging.Handler):
    """Keeps the records."""

    def __init__(self):
        super().__init__()
        self.records = []

    def emit(self, record):
        self.records.append(record)


@pytest.fixture
def kept(monkeypatch):
    handler, logger = Kept(), logging.getLogger('rosout')
    monkeypatch.setattr(logger, 'level', logging.INFO)
    logger.addHandler(handler)
    yield handler
    logger.removeHandler(handler)


def say(text):
    """Log from one place."""
    rosout.info(text)


def test_a_record_has_what_python_gives_it(kept):
    before_s = time.time()
    for text in ('first', '100% of {it}', 'third'):
        say(text)
    rospy.loginfo('by rospy')
    *ours, theirs = kept.records
    assert [record.getMessage() for record in ours] == ['first', '100% of {it}', 'third']
    assert ours[0].lineno == ours[1].lineno == say.__code__.co_firstlineno + 2
    for record in ours:
        assert set(vars(record)) == set(vars(theirs))
        assert (record.funcName, record.filename) == ('say', os.path.basename(__file__))
        for name in ('name', 'levelno', 'levelname', 'process', 'processName', 'thread',
                     'threadName', 'module', 'pathname', 'args', 'exc_info'):
            assert getattr(record, name) == getattr(theirs, name)
        assert before_s <= record.created <= theirs.created
        assert record.msecs == pytest.approx(record.created % 1 * 1000, abs=1)
        assert record.created - record.relativeCreated / 1000 == pytest.approx(
            theirs.created - theirs.relativeCreated / 1000, abs=1e-3)
    assert ours[0].created < ours[1].created < ours[2].created


def test_records_of_two_places(kept):
    for _ in range(2):
        rosout.info('here')
        rosout.info('there')
    lines = [record.lineno for record in kept.records]
    assert [line - lines[0] for line in lines] == [0, 1, 0, 1]


class Speaker:
    """Logs from a method, by prompt_log and by rospy."""

    def speak(self):
        rosout.info('here')
        rospy.loginfo('there')


def test_a_method_has_its_class_before_it(kept):
    Speaker().speak()
    assert [record.funcName for record in kept.records] == ['Speaker.speak'] * 2


@pytest.mark.parametrize('error', [ConnectionRefusedError('no master'), UnicodeError('text'),
                                   rospy.ROSException('closed')])
def test_whoever_logs_goes_on_though_the_line_does_not_reach_rosout(monkeypatch, error):
    def refuse(_):
        raise error
    monkeypatch.setattr(rosout.rosout, '_rosout_pub', SimpleNamespace(publish=refuse))
    monkeypatch.setattr(rosout.parameters, 'log_topics_are_wanted', lambda: False)
    handler, logger = rosout._RosoutHandler(), logging.getLogger('refused')
    logger.propagate = False
    logger.addHandler(handler)
    for _ in range(2):
        logger.error('a line')


def test_a_log_file_is_still_rolled_over(tmp_path):
    path = str(tmp_path / 'node.log')
    handler = logging.handlers.RotatingFileHandler(path, maxBytes=2000, backupCount=1)
    handler.shouldRollover = rosout.seldom(handler.shouldRollover)
    looks = []
    logger = logging.getLogger('rolled over')
    logger.propagate = False
    logger.addHandler(handler)
    for number in range(1000):
        logger.error('%03d %s', number, 'x' * 20)
        looks.append(os.path.getsize(path))
    handler.close()
    assert os.path.exists(path + '.1')
    assert max(looks) < 2000 + 100 * 25
    with open(path) as file:
        assert file.read().splitlines()[-1].startswith('999')
