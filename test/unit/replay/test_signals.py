"""Signals that this process sends to itself."""
import os
import signal

import pytest

from img_recog.replay.signals import Interrupts

NUMBERS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP


@pytest.fixture(autouse=True)
def handlers_as_before():
    before = {number: signal.getsignal(number) for number in NUMBERS}
    yield
    for number, handler in before.items():
        signal.signal(number, handler)


def send(number):
    """Return when the handler has run, which it does between two instructions of Python."""
    signal.raise_signal(number)


@pytest.mark.parametrize('number', NUMBERS)
def test_a_signal_is_an_exception(number):
    Interrupts()
    with pytest.raises((KeyboardInterrupt, SystemExit)) as caught:
        send(number)
    if number == signal.SIGINT:
        assert caught.type is KeyboardInterrupt
    else:
        assert caught.value.code == 128 + number


@pytest.mark.parametrize('number', NUMBERS)
def test_while_it_is_held_it_comes_at_the_end(number):
    interrupts, steps = Interrupts(), []
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        with interrupts.held():
            send(number)
            steps.append('held')
        steps.append('after it')
    assert steps == ['held']
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        send(number)


def test_held_for_nothing():
    with Interrupts().held():
        pass


def test_an_error_in_what_is_held_comes_first():
    interrupts = Interrupts()
    with pytest.raises(ValueError):
        with interrupts.held():
            send(signal.SIGINT)
            raise ValueError


def test_what_is_ignored_stays_ignored():
    signal.signal(signal.SIGHUP, signal.SIG_IGN)
    Interrupts()
    os.kill(os.getpid(), signal.SIGHUP)
    assert signal.getsignal(signal.SIGHUP) == signal.SIG_IGN
