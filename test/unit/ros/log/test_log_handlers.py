"""The log of a node on a full disk, without a terminal, and the size of its files."""
import logging
import os
import re
import subprocess
import sys
from logging.handlers import RotatingFileHandler

import pytest
import rospy
from rosgraph.roslogging import RosStreamHandler

from img_recog.ros.log import log_handlers

# a limit of the size of files behaves like a full disk, without root, and can be removed again
_SCRIPT = '''
import logging, resource, sys
from logging.handlers import RotatingFileHandler
from img_recog.ros.log import log_handlers
root = logging.getLogger()
root.setLevel(logging.INFO)
root.addHandler(RotatingFileHandler(sys.argv[1], 'a', 50000000, 4))
log_handlers.protect()
root.info('before')
resource.setrlimit(resource.RLIMIT_FSIZE, (1000, -1))
for number in range(100):
    root.info('full %d %s', number, 'x' * 100)
resource.setrlimit(resource.RLIMIT_FSIZE, (-1, -1))
for _ in range(100):
    root.info('again %s', 'x' * 100)
'''


@pytest.fixture
def handlers(monkeypatch):
    """A function that replaces the handlers of rospy's log and protects them."""
    def use(*handlers):
        monkeypatch.setattr(logging.getLogger(), 'handlers', [])
        monkeypatch.setattr(logging.getLogger('rosout'), 'handlers', list(handlers))
        monkeypatch.setattr(logging.getLogger('rosout'), 'propagate', False)
        monkeypatch.setattr(logging.getLogger('rosout'), 'level', logging.INFO)
        log_handlers.protect()
        return logging.getLogger('rosout')
    monkeypatch.delenv('ROS_PYTHON_LOG_CONFIG_FILE', raising=False)
    return use


def test_a_full_disk_costs_one_line_and_the_log_continues_when_there_is_space(tmp_path):
    path = tmp_path / 'node.log'
    result = subprocess.run([sys.executable, '-c', _SCRIPT, str(path)], timeout=90,
                            stderr=subprocess.PIPE, universal_newlines=True)
    line, = result.stderr.splitlines()
    assert line.startswith('[WARN] cannot write to {}: File too large; '.format(path)), line
    assert result.returncode == 0
    written = path.read_text().splitlines()
    assert written[0] == 'before' and 'full 0 ' in written[1]
    assert written[-90:] == ['again ' + 'x' * 100] * 90


def test_a_file_that_accepts_nothing(handlers, capfd):
    log = handlers(RotatingFileHandler('/dev/full', 'a', 50000000, 4))
    for number in range(50):
        log.info('line %d', number)
    out, err = capfd.readouterr()
    assert out == '' and err.count('\n') == 1
    assert err.startswith('[WARN] cannot write to /dev/full: No space left on device; ')


def test_each_reason_is_said_once(handlers, capfd, monkeypatch):
    handler = logging.FileHandler(os.devnull)
    log, errors = handlers(handler), []
    monkeypatch.setattr(handler, 'format', lambda record: 1 / 0 if errors else [].pop())
    for _ in range(3):
        log.info('a line')
    errors.append(True)
    for _ in range(3):
        log.info('a line')
    lines = capfd.readouterr().err.splitlines()
    assert [reason for line in lines for reason in ('pop from', 'division') if reason in line] == [
        'pop from', 'division'] and len(lines) == 2


class Unprintable:
    def __str__(self):
        raise OSError('no text')


@pytest.mark.parametrize('values, reason', [
    (('x',), r'%d format: a .*number is required, not str'), ((1, 2), 'not all arguments'),
    ((Unprintable(),), '(no text|number is required)')])
def test_a_text_that_does_not_fit_its_values_is_not_called_a_fault_of_the_file(
        handlers, capfd, monkeypatch, values, reason):
    monkeypatch.setattr(log_handlers, '_wrong_lines', set())
    terminal = RosStreamHandler(False, sys.stdout, sys.stderr)
    handlers(RotatingFileHandler(os.devnull, 'a', 50000000, 4), terminal)
    for _ in range(3):
        rospy.loginfo('got %d', *values)
    line, = capfd.readouterr().err.splitlines()
    assert re.fullmatch(r"\[WARN\] a line of the log is left out: the text 'got %d' in "
                        r'test_log_handlers.py, line \d+, does not fit its values: .*{}.*; '
                        'correct it'.format(reason), line), line


def test_a_terminal_that_is_gone_does_not_reach_the_caller(handlers, capfd):
    read, write = os.pipe()
    os.close(read)
    with os.fdopen(write, 'w', buffering=1) as terminal:
        log = handlers(RosStreamHandler(False, terminal, terminal))
        for _ in range(5):
            log.info('a line')
        assert capfd.readouterr().err.count('cannot write to the terminal: Broken pipe') == 1
        with open(os.devnull, 'w') as null:
            os.dup2(null.fileno(), write)       # what could not be written is still in the buffer


@pytest.mark.parametrize('configured, given, expected', [
    ('', (50000000, 4), (10000000, 4)), ('', (1000, 4), (1000, 4)), ('', (0, 0), (0, 0)),
    ('/my/log.conf', (50000000, 4), (50000000, 4))])
def test_files_are_smaller_than_by_default_but_a_users_configuration_is_kept(
        handlers, monkeypatch, tmp_path, configured, given, expected):
    monkeypatch.setenv('ROS_PYTHON_LOG_CONFIG_FILE', configured)
    handler = RotatingFileHandler(str(tmp_path / 'node.log'), 'a', *given)
    handlers(handler)
    assert (handler.maxBytes, handler.backupCount) == expected
    handler.close()


def test_the_default_size_is_that_of_rosgraph():
    path = os.path.join(os.environ.get('ROS_ETC_DIR', '/etc/ros'), 'python_logging.conf')
    if not os.path.exists(path):
        pytest.skip('this distribution has no ' + path)
    with open(path) as file:
        assert "'a', 50000000, 4)" in file.read()
