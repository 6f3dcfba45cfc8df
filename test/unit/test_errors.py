"""Errors for users: problem and advice, in one line."""
import pytest

from img_recog.errors import UserError, one_line


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
