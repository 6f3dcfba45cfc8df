"""Texts that programs print, held whole in files: ./run test --accept writes them again."""
import difflib
import os

from img_recog_helpers.pages import ROOT

FOLDER = os.path.join('test', 'expected')
_ACCEPT = 'IMG_RECOG_ACCEPT'        # of the environment, set by ./run test --accept


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
