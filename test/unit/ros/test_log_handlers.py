"""The log of a node without a log file, on a full disk, and without a terminal."""
import contextlib
import logging
import os
import subprocess
import sys
from logging.handlers import RotatingFileHandler
from unittest.mock import MagicMock

import pytest
import rospy
from rosgraph import roslogging
from rosgraph.roslogging import RosStreamHandler

from img_recog.ros import log_handlers

# a limit of the size of files behaves like a full disk, without root, and can be removed again
_SCRIPT = '''
import logging, resource, sys
from logging.handlers import RotatingFileHandler
from img_recog.ros import log_handlers
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


def test_a_file_changes_at_its_size_which_is_looked_at_seldom(handlers, tmp_path, monkeypatch):
    handler = RotatingFileHandler(str(tmp_path / 'node.log'), 'a', 1000, 2)
    formatted, original = [], handler.format
    monkeypatch.setattr(handler, 'format', lambda record: formatted.append(1) or original(record))
    log = handlers(handler)
    for number in range(1000):
        log.info('line %d %s', number, 'x' * 100)
    assert 1000 < len(formatted) < 1050
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        'node.log', 'node.log.1', 'node.log.2']
    assert 'line 999 ' in (tmp_path / 'node.log').read_text().splitlines()[-1]


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


@pytest.fixture
def configure(monkeypatch, tmp_path):
    """A function that configures logging like rospy.init_node, with a ROS_HOME."""
    for name in (None, 'rosout'):
        monkeypatch.setattr(logging.getLogger(name), 'handlers', [])
        monkeypatch.setattr(logging.getLogger(name), 'level', logging.WARNING)
    for name in ('configure_logging', 'renew_latest_logdir'):
        monkeypatch.setattr(roslogging, name, getattr(roslogging, name))
    monkeypatch.setattr(rospy.core, '_log_filename', None)
    for name in ('ROS_LOG_DIR', 'ROS_PYTHON_LOG_CONFIG_FILE'):
        monkeypatch.delenv(name, raising=False)

    def call(ros_home):
        monkeypatch.setenv('ROS_HOME', str(ros_home))
        log_handlers.install()
        rospy.core.configure_logging('/ns/node')
    yield call
    for handler in logging.getLogger().handlers:
        with contextlib.suppress(OSError):      # the disk is full
            handler.close()


def below_a_file(folder):
    (folder / 'file').write_text('')
    return folder / 'file' / 'ros'


def with_a_file_in_the_place_of_the_folder(folder):
    (folder / 'log').write_text('')
    return folder


def with_a_folder_in_the_place_of_the_file(folder):
    (folder / 'log' / 'ns_node.log').mkdir(parents=True)
    return folder


@pytest.mark.parametrize('prepare, reason', [
    (below_a_file, 'cannot create log directory'),
    (with_a_file_in_the_place_of_the_folder, 'is in the way'),
    (with_a_folder_in_the_place_of_the_file, 'log/ns_node.log: Is a directory')])
def test_without_a_file_one_line_says_so_and_the_terminal_has_the_log(configure, tmp_path, capfd,
                                                                      prepare, reason):
    configure(prepare(tmp_path))
    rospy.loginfo('a line')
    rospy.logerr('an error')
    logging.getLogger('rospy.internal').warning('not for the terminal')
    out, err = capfd.readouterr()
    warning, error = err.splitlines()
    assert reason in warning and 'ROS_LOG_DIR' in warning, warning
    assert '[INFO]' in out and out.endswith(': a line\n') and error.endswith(': an error')
    assert rospy.core._log_filename is None


def test_with_a_file_rosgraph_configures_the_log(configure, tmp_path, capfd):
    configure(tmp_path / 'new' / 'home')
    rospy.loginfo('a line')
    path = tmp_path / 'new' / 'home' / 'log' / 'ns_node.log'
    assert path.read_text().endswith(': a line\n')
    assert rospy.core._log_filename == str(path)
    assert 'cannot' not in capfd.readouterr().err


def test_nodes_that_start_at_the_same_time_do_not_remove_one_anothers_link(configure, tmp_path,
                                                                           monkeypatch, capfd):
    configure(tmp_path)
    roslogging.configure_logging('node', filename='run/node.log')
    assert (tmp_path / 'log' / 'latest').resolve() == tmp_path / 'log' / 'run'
    # as for a link that another node removes between the two calls of rosgraph
    monkeypatch.setattr(os, 'remove', MagicMock(side_effect=FileNotFoundError))
    roslogging.configure_logging('node', filename='run/node.log')
    assert 'symlink' not in capfd.readouterr().err


def test_the_first_line_of_rospy_on_a_full_disk_is_no_traceback(configure, tmp_path, capfd):
    (tmp_path / 'log').mkdir()
    os.symlink('/dev/full', str(tmp_path / 'log' / 'ns_node.log'))
    configure(tmp_path)
    logging.getLogger('rospy').warning('a line')
    line, = capfd.readouterr().err.splitlines()
    assert line.startswith('[WARN] cannot write to ') and 'No space left on device' in line
