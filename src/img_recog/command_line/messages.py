"""Texts for a terminal in English or Japanese, by the table messages_ja.txt.

./run reads the same table: a line in English, as it is in the code, then one in Japanese, then an
empty one. Each {} is the place of a value.
"""
import functools
import os
import pathlib
from typing import Dict, Iterator, List, Mapping


def is_japanese(environment: Mapping[str, str] = os.environ) -> bool:
    """Return whether the user has chosen Japanese: the first of three variables that is set.

    >>> is_japanese({'LANG': 'ja_JP.UTF-8'}), is_japanese({'LC_ALL': 'C', 'LANG': 'ja_JP.UTF-8'})
    (True, False)
    """
    names = ('LC_ALL', 'LC_MESSAGES', 'LANG')
    return next(filter(None, map(environment.get, names)), '').startswith('ja')


@functools.lru_cache(maxsize=None)
def japanese() -> Dict[str, str]:
    """Return the table: the Japanese text by the English one."""
    return dict(entries(pathlib.Path(__file__).with_name('messages_ja.txt')))


def entries(path: pathlib.Path) -> Iterator[List[str]]:
    """Yield the lines of each entry of a table of texts; an empty line ends an entry."""
    for entry in path.read_text(encoding='utf-8').strip().split('\n\n'):
        if not entry.startswith('#'):
            yield entry.splitlines()


def message(english: str, *values: object) -> str:
    """Return a text in the language of the user, with these values at its {}."""
    return (japanese().get(english, english) if is_japanese() else english).format(*values)
