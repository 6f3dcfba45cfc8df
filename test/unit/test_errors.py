"""Errors for users: problem and advice, in one line."""
import signal
import subprocess
import sys

import pytest

from img_recog.errors import (MAX_FOREIGN, MAX_LINE, UserError, named_in_crashes, one_line,
                              shortened)


@pytest.mark.parametrize('error, text', [
    (ValueError('two\n  lines'), 'two lines'), (KeyError(), 'KeyError'), ('a\tb', 'a b'),
    (FileNotFoundError(2, 'No such file or directory', 'x'), 'No such file or directory'),
    (OSError('only a text'), 'only a text')])
def test_one_line(error, text):
    assert one_line(error) == text


@pytest.mark.parametrize('text, expected', [
    ('', ''), ('plain, ünïcode, 日本', 'plain, ünïcode, 日本'),
    ('x\n[FATAL] forged\x1b[2J', r'x\n[FATAL] forged\x1b[2J'),
    ('\r\b\x9b\u202e\u2028', r'\r\x08\x9b\u202e\u2028'), ('\udcff', r'\udcff')])
def test_characters_that_cannot_be_printed_are_escaped(text, expected):
    assert shortened(text) == expected and expected.isprintable()


@pytest.mark.parametrize('length', [200, 201, 400, 401, 8 << 20])
def test_of_a_long_text_beginning_and_end_remain(length):
    text = 'begin' + 'x' * (length - 8) + 'end'
    result = shortened(text)
    assert len(result) == MAX_FOREIGN == 200
    assert result.startswith('begin') and result.endswith('end')
    assert (' ... ' in result) == (length > 200)


def test_a_long_text_of_control_characters_is_shortened():
    assert len(shortened('\x1b' * 190)) == MAX_FOREIGN


def test_one_line_is_shortened_and_escaped():
    assert one_line(ValueError('x\n' * 8000 + '\x1b[2J')).endswith(r'x x \x1b[2J')
    assert len(one_line(ValueError('x' * 8000))) == MAX_FOREIGN
    assert one_line(UserError('x' * 300, 'a\nb')) == 'x' * 300 + '; a b'
    assert len(one_line(UserError('x' * 8000))) == MAX_LINE == 2000


# the library crashes in a thread of its own, between two calls
CRASH = """
import faulthandler, threading
from img_recog.errors import named_in_crashes
def work(path):
    thread = threading.Thread(target=faulthandler._sigabrt)
    thread.start()
    thread.join()
named_in_crashes('reads ' + {0!r}, work, {0!r})
"""


@pytest.mark.parametrize('path, line', [('/a b/film.flv', '<reads /a b/film.flv>'),
                                        ('a\n.flv', r'<reads a\n.flv>')])
def test_a_crash_has_a_line_that_names_what_was_read(path, line):
    crashed = subprocess.run([sys.executable, '-c', CRASH.format(path)], stderr=subprocess.PIPE,
                             universal_newlines=True)
    assert crashed.returncode == -signal.SIGABRT
    assert sum(line in each for each in crashed.stderr.splitlines()) == 1, crashed.stderr


def test_a_named_call_gives_and_raises_what_the_function_does():
    assert named_in_crashes('reads a.flv', max, 2, 3) == 3
    with pytest.raises(ZeroDivisionError):
        named_in_crashes('reads a.flv', divmod, 2, 0)
