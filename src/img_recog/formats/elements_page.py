"""Prints doc/elements.md, the table of elements as a page."""
import sys
from typing import Dict, Iterator

from img_recog.formats.elements import SDF, URDF, Row

_HEAD = """# Elements of robots and worlds

What becomes of each element of SDF (1.4 to 1.9) and of URDF with `<gazebo>` tags.
`check_world.py`, `check_robot.py` and the log say what a file has of the last column, what is
misspelt, and what is in no row. An element with `=` is only named if it has another value than
that. This page is printed by

    python3 -m img_recog.formats.elements_page > doc/elements.md

"""


def lines() -> Iterator[str]:
    """Yield the lines of the page."""
    yield from _HEAD.splitlines()
    for title, table in (('SDF', SDF), ('URDF', URDF)):
        yield from ('## ' + title, '',
                    '| in | simulated or drawn | of no effect here | not simulated |',
                    '|---|---|---|---|')
        yield from _rows(table)
        yield ''


def _rows(table: Dict[str, Row]) -> Iterator[str]:
    for path, row in table.items():
        if not row.anything:
            yield '| `{}` | {} | {} | {} |'.format(
                path, _words(row.simulated + ' ' + row.drawn),
                _words(row.no_effect) + (' ({})'.format(row.why) if row.why else ''),
                _words(row.not_simulated))


def _words(text: str) -> str:
    return ' '.join('`{}`'.format(word) for word in text.split())


if __name__ == '__main__':
    sys.stdout.write('\n'.join(lines()))
