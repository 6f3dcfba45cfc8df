"""Texts that programs print, held whole in files: ./run test --accept writes them again."""
import difflib
import os
from typing import Callable

from img_recog.errors import UserError
from img_recog_helpers.pages import ROOT

FOLDER = os.path.join('test', 'expected')
_ACCEPT = 'IMG_RECOG_ACCEPT'        # of the environment, set by ./run test --accept
_GIVES = '\n=>'


def check(path: str, text: str) -> None:
    """Compare a text with a file, or write it there; path: relative to the root of the package."""
    file = os.path.join(ROOT, path)
    if os.environ.get(_ACCEPT):
        os.makedirs(os.path.dirname(file), exist_ok=True)
        with open(file, 'w', encoding='utf-8') as opened:
            opened.write(text)
        return
    with open(file, encoding='utf-8') as opened:
        lines = list(difflib.unified_diff(opened.read().splitlines(), text.splitlines(), path,
                                          'now', n=0, lineterm=''))
    assert not lines, '\n'.join([*lines, 'if this is wanted: ./run test --accept'])


def check_printed(name: str, text: str) -> None:
    """Compare what a program has printed with a file of test/expected/."""
    check(os.path.join(FOLDER, name), text)


def check_cases(name: str, printed: Callable[[str], str]) -> None:
    """Compare what a function makes of texts in a file of test/expected/ with what is below each.

    Blocks in the file are divided by an empty line: lines that begin with # say what the text is
    for, then the text, a line =>, and what the function returns, or the line of its UserError.
    """
    with open(os.path.join(ROOT, FOLDER, name), encoding='utf-8') as opened:
        blocks = opened.read().strip().split('\n\n')
    check_printed(name, '\n'.join(_with_result(block.partition(_GIVES)[0], printed)
                                  for block in blocks))


def _with_result(given: str, printed: Callable[[str], str]) -> str:
    text = '\n'.join(line for line in given.splitlines() if not line.startswith('#'))
    try:
        result = printed(text) or 'nothing'
    except UserError as error:
        result = 'refused: {}'.format(error)
    return '{}{}\n{}\n'.format(given, _GIVES, result)
