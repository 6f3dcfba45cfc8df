"""Keys from a pseudo-terminal."""
import contextlib
import os
import pty
import termios
from unittest import mock

import pytest

from img_recog.nodes.teleop_key import Keyboard
from img_recog_helpers.waiting import DEADLINE_S


@pytest.fixture
def terminal(monkeypatch):
    """Both ends of a terminal: a descriptor, and a stream that is the standard input."""
    master, slave = pty.openpty()
    with open(slave, 'rb', buffering=0) as stream:
        monkeypatch.setattr('sys.stdin', stream)
        yield master, stream
    with contextlib.suppress(OSError):      # closed by the test
        os.close(master)


def test_keys_are_read_one_by_one_without_enter(terminal):
    master, stream = terminal
    with Keyboard(True) as keyboard:
        assert keyboard.present
        assert keyboard.key(0) is None
        for key in 'wxads q':
            os.write(master, key.encode())
            assert keyboard.key(DEADLINE_S) == key
        for written, keys in ((b'ad\n', ['a', 'd', '\n']), ('é'.encode(), ['\ufffd', '\ufffd']),
                              (b'\x1b[A', ['\x1b', '[', 'A'])):
            os.write(master, written)
            assert [keyboard.key(DEADLINE_S) for _ in keys] == keys
        assert keyboard.key(0) is None and keyboard.present


@pytest.mark.parametrize('error', [None, RuntimeError, KeyboardInterrupt, SystemExit])
def test_echo_and_line_mode_are_off_inside_and_restored_after(terminal, error):
    _, stream = terminal
    before, modes = termios.tcgetattr(stream), termios.ECHO | termios.ICANON
    assert before[3] & modes == modes
    with pytest.raises(error) if error else contextlib.nullcontext():
        with Keyboard(True):
            flags = termios.tcgetattr(stream)[3]
            assert flags & modes == 0 and flags & termios.ISIG
            if error:
                raise error
    assert termios.tcgetattr(stream) == before


@pytest.mark.parametrize('error', [None, OSError])
def test_closed_terminal_has_no_keys_and_raises_no_error(terminal, monkeypatch, error):
    master, stream = terminal
    with Keyboard(True) as keyboard:
        assert keyboard.present
        os.close(master)
        if error:       # as on other systems
            monkeypatch.setattr(os, 'read', mock.Mock(side_effect=error))
        assert keyboard.key(DEADLINE_S) is None
        assert not keyboard.present and keyboard.key(0) is None


def test_in_the_background_there_are_no_keys_and_the_terminal_is_unchanged(terminal):
    master, stream = terminal
    before = termios.tcgetattr(stream)
    with Keyboard(False) as keyboard:
        assert keyboard.present is False
        os.write(master, b'w\n')
        assert keyboard.key(0) is None
        assert termios.tcgetattr(stream) == before
    assert stream.read(1) == b'w'


def test_without_a_terminal_the_timeout_is_waited_for(monkeypatch):
    waited = []
    monkeypatch.setattr('img_recog.nodes.teleop_key.time.sleep', waited.append)
    with Keyboard(False) as keyboard:
        assert keyboard.key(0.3) is None
    assert waited == [0.3]
