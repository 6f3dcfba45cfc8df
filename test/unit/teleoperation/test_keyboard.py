"""Keys from a terminal, tested in a child process with a pseudo-terminal."""
import contextlib
import io
import os
import pty
import signal
import termios

import pytest

from img_recog.teleoperation.keyboard import Keyboard
from img_recog_testing.waiting import DEADLINE_S, stretch

KEY_S = 60      # a child waits for a key; it is ended if it hangs for DEADLINE_S


@contextlib.contextmanager
def child_in_terminal(body):
    """Run body(stream, report) in a child whose controlling terminal is a new pseudo-terminal.

    Yields the terminal's other end and a function that returns the child's next report.
    """
    receiving, sending = os.pipe()
    pid, master = pty.fork()
    if pid == 0:
        _run_child(body, sending)
    os.close(sending)
    with open(receiving) as reports:
        try:
            yield master, lambda: reports.readline().rstrip('\n')
            assert reports.read() == ''
        finally:
            with contextlib.suppress(OSError):
                os.close(master)
            os.waitpid(pid, 0)


def _run_child(body, sending):
    try:
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(int(DEADLINE_S * stretch()))

        def report(value):
            os.write(sending, '{!r}\n'.format(value).encode())

        try:
            body(open(0, 'rb', buffering=0, closefd=False), report)
        except BaseException as error:
            report(error)
    finally:
        os._exit(0)


@contextlib.contextmanager
def pseudo_terminal():
    """Yield both ends of a terminal that is not the controlling one: a descriptor and a stream."""
    master, slave = pty.openpty()
    with open(slave, 'rb', buffering=0) as stream:
        yield master, stream
    os.close(master)


def test_keys_are_read_one_by_one_without_enter():
    def body(stream, report):
        with Keyboard(stream) as keyboard:
            report(keyboard.present)
            key = None
            while key != '.':
                key = keyboard.key(KEY_S * stretch())
                report(key)

    with child_in_terminal(body) as (master, next_report):
        assert next_report() == 'True'
        for key in 'wxads q':
            os.write(master, key.encode())
            assert next_report() == repr(key)
        os.write(master, b'ad\n')
        assert [next_report() for _ in range(3)] == ["'a'", "'d'", r"'\n'"]
        os.write(master, 'é'.encode())
        assert [next_report() for _ in range(2)] == [repr('\ufffd')] * 2
        os.write(master, b'\x1b[A')
        assert [next_report() for _ in range(3)] == [r"'\x1b'", "'['", "'A'"]
        os.write(master, b'.')
        assert next_report() == "'.'"


def test_no_key_within_the_timeout():
    def body(stream, report):
        with Keyboard(stream) as keyboard:
            report((keyboard.present, keyboard.key(0), keyboard.present))

    with child_in_terminal(body) as (_, next_report):
        assert next_report() == '(True, None, True)'


def test_echo_and_line_mode_are_off_inside_and_restored_after():
    def body(stream, report):
        before = termios.tcgetattr(stream)
        modes = termios.ECHO | termios.ICANON
        with Keyboard(stream):
            report((before[3] & modes == modes, termios.tcgetattr(stream)[3] & modes))
            report(termios.tcgetattr(stream)[3] & termios.ISIG == termios.ISIG)
        report(termios.tcgetattr(stream) == before)

    with child_in_terminal(body) as (_, next_report):
        assert [next_report() for _ in range(3)] == ['(True, 0)', 'True', 'True']


@pytest.mark.parametrize('exception', [RuntimeError, KeyboardInterrupt, SystemExit])
def test_terminal_is_restored_when_an_exception_is_raised(exception):
    def body(stream, report):
        before = termios.tcgetattr(stream)
        try:
            with Keyboard(stream):
                report(termios.tcgetattr(stream) == before)
                raise exception('inside')
        except exception as error:
            report((str(error), termios.tcgetattr(stream) == before))

    with child_in_terminal(body) as (_, next_report):
        assert [next_report() for _ in range(2)] == ['False', "('inside', True)"]


def test_closed_terminal_has_no_keys_and_raises_no_error():
    def body(stream, report):
        signal.signal(signal.SIGHUP, signal.SIG_IGN)
        with Keyboard(stream) as keyboard:
            report(keyboard.present)
            report((keyboard.key(KEY_S * stretch()), keyboard.present, keyboard.key(0)))
        report('left')

    with child_in_terminal(body) as (master, next_report):
        assert next_report() == 'True'
        os.close(master)
        assert [next_report() for _ in range(2)] == ['(None, False, None)', "'left'"]


def test_process_in_the_background_has_no_keys():
    def body(stream, report):
        report(Keyboard(stream).present)
        pid = os.fork()
        if pid == 0:
            os.setpgid(0, 0)
            before = termios.tcgetattr(stream)
            with Keyboard(stream) as keyboard:
                report((keyboard.present, termios.tcgetattr(stream) == before))
            os._exit(0)
        os.waitpid(pid, 0)

    with child_in_terminal(body) as (_, next_report):
        assert [next_report() for _ in range(2)] == ['True', '(False, True)']


def test_terminal_that_is_not_the_controlling_one_has_no_keys_and_is_unchanged():
    with pseudo_terminal() as (master, stream):
        assert stream.isatty()
        before = termios.tcgetattr(stream)
        with Keyboard(stream) as keyboard:
            assert keyboard.present is False
            os.write(master, b'w\n')
            assert keyboard.key(0) is None
            assert termios.tcgetattr(stream) == before
        assert stream.read(1) == b'w'


def test_a_file_has_no_keys(tmp_path):
    (tmp_path / 'keys').write_text('wwww')
    with open(str(tmp_path / 'keys')) as stream, Keyboard(stream) as keyboard:
        assert keyboard.present is False
        assert keyboard.key(0) is None
        assert stream.read() == 'wwww'


@pytest.mark.parametrize('stdin', [None, io.StringIO('w'), object()])
def test_standard_input_that_is_not_a_file_has_no_keys(monkeypatch, stdin):
    monkeypatch.setattr('sys.stdin', stdin)
    with Keyboard() as keyboard:
        assert keyboard.present is False
        assert keyboard.key(0) is None


def test_without_keys_the_timeout_is_waited_for(monkeypatch):
    waited = []
    monkeypatch.setattr('img_recog.teleoperation.keyboard.time.sleep', waited.append)
    with Keyboard(io.StringIO()) as keyboard:
        assert keyboard.key(0.3) is None
    assert waited == [0.3]
