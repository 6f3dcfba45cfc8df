"""A helper process: its connection, its signals, and how it ends."""
import multiprocessing
import operator
import os
import signal
import time

import pytest

from img_recog.processes.helper_process import HelperProcess
from img_recog_helpers.waiting import DEADLINE_S, stretch, wait_for

pytestmark = pytest.mark.usefixtures('patient_helper')


def receive(helper):
    assert helper.connection.poll(DEADLINE_S * stretch())
    return helper.connection.recv()


def report(connection, *args):
    """Send what the process is; then wait until the other end is closed."""
    try:
        connection.send((args, os.nice(0), os.getpid()))
        connection.recv()
    except (EOFError, OSError):
        pass


def echo(connection):
    """Send the process id, then what comes, until the other end is closed."""
    try:
        connection.send(os.getpid())
        while True:
            connection.send(connection.recv())
    except (EOFError, OSError):
        pass


def write(connection, memory, value):
    memory[0] = value


def close_and_exit(connection, delay_s):
    connection.close()
    time.sleep(delay_s)


def hang(connection):
    """Neither read the connection nor end."""
    connection.send(os.getpid())
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


def test_what_only_a_new_process_can_get(start):
    memory = multiprocessing.get_context('spawn').RawArray('B', 1)
    helper = start(write, (7,), 0, (memory,))
    assert helper.wait() == helper.end() == 0
    assert memory[0] == 7


def test_messages_arrive_in_order(start):
    helper = start(echo, (), 0)
    receive(helper)
    for number in range(100):
        helper.send(number)
    assert [receive(helper) for _ in range(100)] == list(range(100))
    wait_for(lambda: not helper.is_sending, 'the last message')
    assert not helper.is_broken


@pytest.mark.parametrize('size, count', [(10 ** 7, 3), (5 * 10 ** 4, 100)])
def test_to_send_never_waits(start, size, count):
    helper = start(echo, (), 0)
    os.kill(receive(helper), signal.SIGSTOP)
    for _ in range(count):
        helper.send(bytes(size))        # together more than the connection holds
    assert helper.is_sending and not helper.is_broken
    helper.kill()
    wait_for(lambda: helper.is_broken, 'the end')
    helper.send('nobody')
    assert helper.end() == -signal.SIGKILL


def test_one_that_is_ended_before_it_has_started(start):
    helper = start(report, (bytes(10 ** 7),), 0)
    assert helper.end() == 0


def test_ctrl_c_does_not_end_it(start):
    helper = start(report, (), 0)
    pid = receive(helper)[2]
    os.kill(pid, signal.SIGINT)
    assert helper.end() == 0


def test_a_defect_in_the_target_gives_another_exit_code(start):
    helper = start(operator.methodcaller('no_such_method'), (), 0)
    assert helper.wait() == helper.end() == 1


def test_one_that_is_killed(start):
    helper = start(report, (), 0)
    os.kill(receive(helper)[2], signal.SIGKILL)
    with pytest.raises((EOFError, OSError)):        # this process does not hold the other end
        receive(helper)
    assert helper.wait() == helper.end() == -signal.SIGKILL


def test_a_busy_machine_has_time_for_the_exit_of_one_that_ends_by_itself(start, impatient):
    helper = start(close_and_exit, (1.0,), 0)
    with pytest.raises(EOFError):
        receive(helper)
    assert helper.wait() == 0


@pytest.mark.parametrize('end', [HelperProcess.end, lambda helper: helper.wait(0.2)])
@pytest.mark.parametrize('is_stopped', [False, True])
def test_one_that_hangs_or_is_stopped_is_killed(start, impatient, is_stopped, end):
    helper = start(hang, (), 0)
    pid = receive(helper)
    if is_stopped:
        os.kill(pid, signal.SIGSTOP)
    assert end(helper) == -signal.SIGKILL
