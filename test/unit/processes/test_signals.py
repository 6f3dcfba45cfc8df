"""Interrupts: signals that this process sends to itself."""
import multiprocessing
import os
import signal
import subprocess
import sys

import pytest

from img_recog.processes.signals import Interrupts, uninterrupted

pytestmark = pytest.mark.usefixtures('handlers_as_before')
SIGNALS = signal.SIGINT, signal.SIGTERM, signal.SIGHUP


def send(signum):
    """Send a signal to this process; return when its handler has run."""
    signal.raise_signal(signum)


@pytest.mark.parametrize('signum', SIGNALS)
def test_a_signal_is_an_exception(signum):
    Interrupts()
    with pytest.raises((KeyboardInterrupt, SystemExit)) as caught:
        send(signum)
    if signum == signal.SIGINT:
        assert caught.type is KeyboardInterrupt
    else:
        assert caught.value.code == 128 + signum


@pytest.mark.parametrize('signum', SIGNALS)
def test_a_deferred_signal_is_raised_at_the_end(signum):
    interrupts, steps = Interrupts(), []
    with interrupts.deferred():
        steps.append('none')
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        with interrupts.deferred():
            send(signum)
            steps.append('deferred')
        steps.append('afterwards')
    assert steps == ['none', 'deferred']
    with pytest.raises((KeyboardInterrupt, SystemExit)):
        send(signum)


def test_what_is_started_takes_no_ctrl_c_and_this_process_takes_it_afterwards():
    interrupts, steps = Interrupts(), []
    with pytest.raises(KeyboardInterrupt):
        with interrupts.deferred(), uninterrupted():
            os.kill(os.getpid(), signal.SIGINT)
            assert signal.getsignal(signal.SIGINT) != signal.SIG_IGN
            steps.append(subprocess.run([sys.executable, '-c', (
                'import os, signal; os.kill(os.getpid(), signal.SIGINT)')],
                check=False).returncode)
            process = multiprocessing.get_context('spawn').Process(
                target=signal.raise_signal, args=(signal.SIGINT,))
            process.start()
            process.join()
            steps.append(process.exitcode)
    assert steps == [0, 0]
    with pytest.raises(KeyboardInterrupt):
        send(signal.SIGINT)


def test_an_error_while_deferred_is_raised_first():
    interrupts = Interrupts()
    with pytest.raises(ValueError):
        with interrupts.deferred():
            send(signal.SIGINT)
            raise ValueError


def test_of_ignored_signals_only_sighup_stays_ignored():
    for signum in SIGNALS:
        signal.signal(signum, signal.SIG_IGN)
    Interrupts()
    os.kill(os.getpid(), signal.SIGHUP)
    assert [signum for signum in SIGNALS if signal.getsignal(signum) == signal.SIG_IGN] == [
        signal.SIGHUP]


def test_in_the_last_calls_of_python_a_signal_ends_the_program():
    for signum in SIGNALS:
        done = subprocess.run([sys.executable, '-c', (
            'import atexit, os, signal\n'
            'from img_recog.processes.signals import Interrupts\n'
            'signal.signal(signal.SIGHUP, signal.SIG_DFL)\n'
            'atexit.register(lambda: os.kill(os.getpid(), {}))\n'
            'Interrupts()'.format(int(signum)))], stderr=subprocess.PIPE, check=False)
        assert (done.returncode, done.stderr) == (-signum, b'')
