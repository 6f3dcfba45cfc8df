"""Ctrl-C while a test waits for simulated time."""
import random
import signal
import threading
import time

import pytest

from img_recog.testing.running import InterruptibleCalls, Wakeup

INTERRUPTS, LONGEST_S = 300, 2e-3


@pytest.fixture
def interrupt():
    """A function that has the main thread interrupted after some seconds."""
    before = signal.signal(signal.SIGALRM, signal.default_int_handler)
    yield lambda seconds: signal.setitimer(signal.ITIMER_REAL, seconds)
    signal.setitimer(signal.ITIMER_REAL, 0)
    signal.signal(signal.SIGALRM, before)


def respond():
    time.sleep(1e-3)
    return 'response'


def test_each_interrupt_ends_a_step_and_nothing_stays_locked(interrupt):
    calls, arrived = InterruptibleCalls(respond), Wakeup()
    for _ in range(INTERRUPTS):
        with pytest.raises(KeyboardInterrupt):
            interrupt(random.uniform(1e-5, LONGEST_S))
            while True:
                assert calls.call(lambda: None) == 'response'
                arrived.wait(1e-4)
        # the thread of the subscriber
        taken = threading.Thread(target=arrived.notify, daemon=True)
        taken.start()
        taken.join(10.0)
        assert not taken.is_alive()
    assert calls.call(lambda: None) == 'response'
    calls.end()


def test_a_call_that_was_given_up_does_not_answer_the_next_one():
    responses = iter(('late', 'next'))
    begun = threading.Event()

    def late():
        begun.wait(10.0)
        return next(responses)
    calls = InterruptibleCalls(late)

    def give_up():
        raise AssertionError('it takes too long')
    with pytest.raises(AssertionError, match='it takes too long'):
        calls.call(give_up)
    begun.set()
    assert calls.call(lambda: None) == 'next'
    calls.end()


def test_an_error_of_a_call_is_its_response():
    error = OSError('gone')

    def fail():
        raise error
    calls = InterruptibleCalls(fail)
    assert calls.call(lambda: None) is error
    calls.end()


def test_a_notification_before_the_wait_ends_it():
    arrived, begin_s = Wakeup(), time.monotonic()
    arrived.notify()
    arrived.notify()
    arrived.wait(60.0)
    assert time.monotonic() < begin_s + 30.0
