"""Lines of the log: bounded, and without anything that forges a line or controls a terminal."""
import io
import logging

import pytest
from rosgraph.roslogging import RosStreamHandler

from img_recog.errors import MAX_LINE
from img_recog.ros import log_handlers

FORGED = 'x\n[FATAL] forged\x1b[2J'


@pytest.fixture
def logger():
    """A logger with the handlers of rospy; its records are those of our nodes."""
    before = logging.getLogRecordFactory()
    log_handlers.use_safe_records()
    logger = logging.Logger('test')
    logger.terminal, logger.file = io.StringIO(), io.StringIO()
    logger.addHandler(RosStreamHandler(False, logger.terminal, logger.terminal))
    logger.addHandler(logging.StreamHandler(logger.file))
    yield logger
    logging.setLogRecordFactory(before)


def lines(logger):
    """Return the lines in the file; those on the terminal have the same end."""
    found = logger.file.getvalue().splitlines()
    shown = logger.terminal.getvalue().splitlines()
    assert len(found) == len(shown)
    for line, on_terminal in zip(found, shown):
        assert on_terminal.endswith(line)
    return found


@pytest.mark.parametrize('message, values, line', [
    ('%s is unknown', (FORGED,), r'x\n[FATAL] forged\x1b[2J is unknown'),
    (FORGED + ' is unknown', (), r'x\n[FATAL] forged\x1b[2J is unknown'),
    ('%(name)s is unknown', ({'name': FORGED},), r'x\n[FATAL] forged\x1b[2J is unknown'),
    (ValueError('a\nb'), (), r'a\nb'),        # an object that is no text
    ('file %s', (b'\xff'.decode(errors='surrogateescape'),), r'file \udcff')])
def test_a_line_cannot_be_forged(logger, message, values, line):
    logger.warning(message, *values)
    assert lines(logger) == [line]


def test_ordinary_lines_do_not_change(logger):
    for line in ('', 'blue=12, red=0', 'größer: 100 %', 'a' * MAX_LINE, 'got ${wheel}'):
        logger.info('%s', line)
        assert lines(logger)[-1:] == ([line] if line else [''])


def test_a_line_of_8_mb_is_shortened(logger):
    logger.info('got %s here', 'x\x1b' * (4 << 20))
    line, = lines(logger)
    assert len(line) == MAX_LINE
    assert line.startswith(r'got x\x1bx\x1b') and line.endswith(r'x\x1b here')


def test_a_traceback_keeps_its_lines_but_they_look_like_no_record(logger):
    try:
        raise ValueError(FORGED)
    except ValueError:
        logger.exception('failed: %s', FORGED)
    found = lines(logger)
    assert found[:2] == [r'failed: x\n[FATAL] forged\x1b[2J', 'Traceback (most recent call last):']
    assert found[-2:] == ['    ValueError: x', r'    [FATAL] forged\x1b[2J']
    assert len(found) >= 5


def test_a_traceback_in_the_message_keeps_its_lines(logger):
    """This is how rospy logs the error of a callback."""
    logger.error('bad callback: f\nTraceback (most recent call last):\n  line 1\n\x1b[2Jforged\n')
    assert lines(logger) == ['bad callback: f', '    Traceback (most recent call last):',
                             '      line 1', r'    \x1b[2Jforged']


def test_a_traceback_of_many_and_long_lines_is_shortened(logger):
    logger.error('Traceback (most recent call last)\n' + ('y' * 1000 + '\n') * 1000)
    found = lines(logger)
    assert len(found) < 100 and max(map(len, found)) < 300
    assert any('lines ...' in line for line in found)


@pytest.mark.parametrize('text', ['${time:', '${walltime:', '${time:${time:x}', '${walltime:%Y}'])
def test_fields_of_the_format_of_rosconsole_are_only_text(logger, text):
    """rosgraph's handler replaces them in the message too, and fails without a brace."""
    logger.warning('parameter %s is unknown', text)
    try:
        raise ValueError(text)
    except ValueError:
        logger.exception('failed')
    found = lines(logger)
    assert found[0] == 'parameter {} is unknown'.format(text.replace('${', '$ {'))
    assert found[-1] == '    ValueError: ' + text.replace('${', '$ {')
