"""Errors for users: problem and advice, in one line."""
import pytest

from img_recog.errors import MAX_FOREIGN, MAX_LINE, UserError, one_line, shortened


def test_a_user_error_says_problem_and_advice():
    error = UserError('cannot open a.mp4', 'give another file')
    assert str(error) == 'cannot open a.mp4; give another file'
    assert (error.problem, error.advice) == ('cannot open a.mp4', 'give another file')
    assert str(UserError('no camera')) == 'no camera' and UserError('no camera').advice == ''


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
