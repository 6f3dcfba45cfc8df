"""A helper process: its connection, its signals, and how it ends."""
import operator
import os
import signal
import time

import pytest

from img_recog.helper_process import HelperProcess
from img_recog_testing.waiting import DEADLINE_S, stretch


def receive(helper):
    assert helper.connection.poll(DEADLINE_S * stretch())
    return helper.connection.recv()


def report(connection, *args):
    """Send what the process is; then wait until the other end is closed."""
    connection.send((args, os.nice(0), os.getpid()))
    try:
        connection.recv()
    except EOFError:
        pass


def hang(connection):
    """Neither read the connection nor end."""
    connection.send('here')
    time.sleep(DEADLINE_S * 10)


@pytest.fixture
def start():
    """A function that starts a helper, which is ended after the test."""
    started = []

    def start_helper(*args):
        started.append(HelperProcess(*args))
        return started[-1]
    yield start_helper
    for each in started:
        each.kill()


def test_it_runs_its_target_and_exits_when_it_is_to_end(start):
    helper = start(report, (1, 'two'), 3)
    args, niceness, pid = receive(helper)
    assert args == (1, 'two') and niceness == os.nice(0) + 3 and pid != os.getpid()
    assert helper.end() == 0


def test_ctrl_c_does_not_end_it(start):
    helper = start(report, (), 0)
    pid = receive(helper)[2]
    os.kill(pid, signal.SIGINT)
    assert helper.end() == 0


def test_a_defect_in_the_target_gives_another_exit_code(start):
    helper = start(operator.methodcaller('no_such_method'), (), 0)
    helper._process.join(DEADLINE_S * stretch())
    assert helper.wait() == 1 and helper.end() == 1


def test_one_that_is_killed(start):
    helper = start(report, (), 0)
    os.kill(receive(helper)[2], signal.SIGKILL)
    assert helper.wait() == helper.end() == -signal.SIGKILL


@pytest.mark.parametrize('is_stopped', [False, True])
def test_one_that_hangs_or_is_stopped_is_killed(start, monkeypatch, is_stopped):
    monkeypatch.setattr('img_recog.helper_process._EXIT_TIMEOUT_S', 0.2)
    helper = start(hang, (), 0)
    assert receive(helper) == 'here'
    if is_stopped:
        os.kill(helper._process.pid, signal.SIGSTOP)
    assert helper.wait() is None
    helper.end()
    helper._process.join(DEADLINE_S * stretch())
    assert helper.wait() == -signal.SIGKILL
