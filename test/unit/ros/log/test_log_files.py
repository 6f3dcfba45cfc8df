"""A node whose log file cannot be written logs to the terminal."""
import contextlib
import logging
import os

import pytest
import rospy
from rosgraph import roslogging

from img_recog.ros.log import log_files


@pytest.fixture
def configure(monkeypatch, tmp_path):
    """A function that configures logging like rospy.init_node, with a ROS_HOME."""
    for name in (None, 'rosout'):
        monkeypatch.setattr(logging.getLogger(name), 'handlers', [])
        monkeypatch.setattr(logging.getLogger(name), 'level', logging.WARNING)
    monkeypatch.setattr(roslogging, 'configure_logging', roslogging.configure_logging)
    monkeypatch.setattr(rospy.core, '_log_filename', None)
    for name in ('ROS_LOG_DIR', 'ROS_PYTHON_LOG_CONFIG_FILE'):
        monkeypatch.delenv(name, raising=False)

    def call(ros_home):
        monkeypatch.setenv('ROS_HOME', str(ros_home))
        log_files.install()
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


@pytest.mark.parametrize('prepare', [
    below_a_file, with_a_file_in_the_place_of_the_folder, with_a_folder_in_the_place_of_the_file])
def test_without_a_file_one_line_says_so_and_the_terminal_has_the_log(configure, tmp_path, capfd,
                                                                      prepare):
    path = prepare(tmp_path)
    configure(path)
    rospy.loginfo('a line')
    rospy.logerr('an error')
    logging.getLogger('rospy.internal').warning('not for the terminal')
    out, err = capfd.readouterr()
    warning, error = err.splitlines()
    assert warning.startswith('[WARN] there is no log file, only the terminal: cannot write {}: '
                              .format(path / 'log' / 'ns_node.log')), warning
    assert 'ROS_LOG_DIR' in warning
    assert '[INFO]' in out and out.endswith(': a line\n') and error.endswith(': an error')
    assert rospy.core._log_filename is None


def test_with_a_file_rosgraph_configures_the_log(configure, tmp_path, capfd):
    configure(tmp_path / 'new' / 'home')
    rospy.loginfo('a line')
    path = tmp_path / 'new' / 'home' / 'log' / 'ns_node.log'
    assert path.read_text().endswith(': a line\n')
    assert rospy.core._log_filename == str(path)
    assert 'cannot' not in capfd.readouterr().err


def test_the_first_line_of_rospy_on_a_full_disk_is_no_traceback(configure, tmp_path, capfd):
    (tmp_path / 'log').mkdir()
    os.symlink('/dev/full', str(tmp_path / 'log' / 'ns_node.log'))
    configure(tmp_path)
    logging.getLogger('rospy').warning('a line')
    line, = capfd.readouterr().err.splitlines()
    assert line.startswith('[WARN] cannot write to ') and 'No space left on device' in line
