"""A recording, with a stand-in for the program that records."""
import contextlib
import os
import signal
import stat
import subprocess
import sys
import threading
import xml.etree.ElementTree as ElementTree
from concurrent.futures import ThreadPoolExecutor

import pytest
import roslaunch.config
import roslaunch.xmlloader

from img_recog.errors import UserError, one_line
from img_recog.processes.bag_recording import BagRecording, RecordingSwitch
from img_recog.processes import bag_recording
from img_recog_helpers.pages import ROOT
from img_recog_helpers.waiting import DEADLINE_S, wait_for

# rosrun with the arguments `rosbag record --quiet --lz4 --size=N -O PATH TOPICS`
PROGRAM = '''#!/bin/sh
file=$7
printf '%s ' "$@" >"$file.arguments"
{}
'''
OPEN = ': >"$file.active"\n'
COMPLETE = 'trap \'mv "$file.active" "$file"; exit 0\' INT\n'
WRITE = 'echo some >"$file.active"\n'
UNTIL_FULL = 'while [ ! -e "$file.full" ]; do sleep 0.05; done'
MOVE = '; mv "$file.active" "$file"'
LOOP = 'while :; do sleep 0.05; done\n'


@pytest.fixture
def recording(tmp_path, monkeypatch):
    """A function that starts a recording with a script as the program."""
    for limit in ('_START_TIMEOUT_S', '_END_TIMEOUT_S'):    # a busy machine needs longer
        monkeypatch.setattr(bag_recording, limit, DEADLINE_S)
    started = []

    def start(script, **options):
        program = tmp_path / 'rosrun'
        program.write_text(PROGRAM.format(script))
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        monkeypatch.setenv('PATH', '{}:{}'.format(tmp_path, os.environ['PATH']))
        started.append(BagRecording(str(tmp_path / 'new.bag'), ['/odom', '/scan'], 7, **options))
        return started[-1]
    yield start
    for each in started:
        with contextlib.suppress(UserError):
            each.stop()


def fill(running):
    """Let a program of UNTIL_FULL go on, and wait for its end."""
    with open(running.path + '.full', 'w'):
        wait_for(lambda: not running.is_running, 'the end')


def test_a_recording_is_complete_when_it_has_stopped(recording, tmp_path):
    running = recording(COMPLETE + WRITE + LOOP)
    assert running.is_running and not running.check()
    running.stop()
    assert not running.is_running and (tmp_path / 'new.bag').exists() and not running.check()
    assert (tmp_path / 'new.bag.arguments').read_text() == (
        'rosbag record --quiet --lz4 --size=7 -O {} /odom /scan '.format(tmp_path / 'new.bag'))


def test_a_file_that_cannot_be_written(recording, tmp_path):
    with pytest.raises(UserError) as error:
        recording(OPEN + 'sleep 0.3; printf "\\033[31m[ERROR] [12.5]: Error writing: disk full'
                         '\\033[0m\\n" >&2; printf "terminate \\377" >&2; exit 1')
    assert one_line(error.value).startswith(
        'cannot record {}: Error writing: disk full; '.format(tmp_path / 'new.bag'))
    assert not (tmp_path / 'new.bag.active').exists()


def test_a_program_that_writes_nothing_is_ended(recording, tmp_path, monkeypatch):
    monkeypatch.setattr(bag_recording, '_START_TIMEOUT_S', 0.5)
    with pytest.raises(UserError, match='there is no file after 0.5 s; see whether the master'):
        recording('echo $$ >"$file.pid"\n' + LOOP)
    pid = int((tmp_path / 'new.bag.pid').read_text())
    assert not os.path.exists('/proc/{}'.format(pid))


def test_a_start_ends_with_the_program(recording):
    with pytest.raises(UserError, match='there is no file'):
        recording(LOOP, is_ending=lambda: True)


@pytest.mark.parametrize('end, problem', [
    (UNTIL_FULL + '; echo "the disk is full" >&2; exit 1', 'cannot record .*: the disk is full; '),
    ('echo "[ WARN] [12.5]: Less than 5 x 1G of space free" >&2\n'     # that is no reason
     'echo "[ERROR] [12.6]: Less than 1G" >&2\n' + UNTIL_FULL + MOVE + '; exit 1',
     'the recording .*new.bag has ended: Less than 1G;')])
def test_a_recording_that_fails_later_is_reported_once_and_keeps_what_it_has(
        recording, tmp_path, end, problem):
    running = recording(WRITE + end)
    fill(running)
    with pytest.raises(UserError, match='^' + problem):
        running.check()
    name = 'new.bag' if MOVE in end else 'new.bag.active'
    assert not running.check() and (tmp_path / name).read_text() == 'some\n'


def test_the_largest_size_is_reported_once(recording):
    running = recording(WRITE + UNTIL_FULL + MOVE)
    fill(running)
    assert [running.check(), running.check()] == [True, False]


def test_a_stop_without_a_file(recording):
    running = recording('trap "exit 0" INT\n' + WRITE + LOOP)
    with pytest.raises(UserError, match='not complete'):
        running.stop()


def test_it_ends_with_a_process_that_is_killed(recording, tmp_path):
    recording(COMPLETE + WRITE + LOOP).stop()
    path = tmp_path / 'other.bag'
    child = subprocess.Popen([sys.executable, '-c', (
        'import os, signal, sys\n'
        'from img_recog.processes import bag_recording\n'
        'bag_recording._START_TIMEOUT_S = float(sys.argv[2])\n'
        'bag_recording.BagRecording(sys.argv[1], ["/odom"])\n'
        'os.kill(os.getpid(), signal.SIGKILL)'), str(path), str(DEADLINE_S)])
    assert child.wait(DEADLINE_S) == -signal.SIGKILL
    wait_for(path.exists, 'a complete file')


def in_another_thread(call, *arguments):
    """Return the result of a call in a thread that has ended, also for the kernel."""
    with ThreadPoolExecutor(1) as thread:
        result = thread.submit(call, *arguments).result(DEADLINE_S)
        number = thread.submit(threading.get_native_id).result(DEADLINE_S)
    wait_for(lambda: str(number) not in os.listdir('/proc/self/task'), 'the end of the thread')
    return result


def test_one_recording_for_all_who_start_and_stop_it(recording, tmp_path):
    recorder = RecordingSwitch(lambda: recording(COMPLETE + WRITE + LOOP))
    path = str(tmp_path / 'new.bag')
    assert recorder.path == '' == recorder.record(False)
    assert in_another_thread(recorder.record, True) == path
    # it would have ended if the thread that is over were that of the recording
    assert in_another_thread(recorder.record, True) == path == recorder.path
    assert recorder.check() == '' and not os.path.exists(path)
    assert in_another_thread(recorder.record, False) == path and os.path.exists(path)
    assert recorder.path == '' == recorder.record(False) and recorder.check() == ''


def test_a_recorder_after_a_failure(recording, tmp_path):
    scripts = ['exit 3', WRITE + UNTIL_FULL + MOVE, COMPLETE + WRITE + LOOP]
    started = []
    recorder = RecordingSwitch(lambda: started.append(recording(scripts.pop(0))) or started[-1])
    with pytest.raises(UserError, match='exit code 3'):
        recorder.record(True)
    path = str(tmp_path / 'new.bag')
    assert recorder.path == ''
    recorder.record(True)
    fill(started[-1])
    assert recorder.path == ''
    assert [recorder.check(), recorder.check()] == [path, '']
    assert recorder.record(True) == path == recorder.path
    recorder.record(False)


def test_the_page_records_the_topics_that_the_demo_does():
    tree = ElementTree.parse(os.path.join(ROOT, 'launch', 'record.launch'))
    values = {each.get('name'): each.get('value') for each in tree.iter('arg')}
    absolute, relative = values['topics'].split(), values['robot_topics'].split()
    assert (*absolute, *relative) == bag_recording.TOPICS
    # several robots have them in each namespace
    config = roslaunch.config.ROSLaunchConfig()
    roslaunch.xmlloader.XmlLoader().load(
        os.path.join(ROOT, 'launch', 'record.launch'), config, argv=['robots:=4'], verbose=False)
    assert config.nodes[0].args.endswith(" -O 'demo.bag' --regex {}|(/.+)?/({})".format(
        '|'.join(absolute), '|'.join(relative)))


def test_a_machine_without_setpriv(recording, monkeypatch, tmp_path):
    monkeypatch.setenv('PATH', '')
    with pytest.raises(UserError, match='^cannot record: setpriv: .*; install the package util-'):
        BagRecording(str(tmp_path / 'new.bag'), [])
