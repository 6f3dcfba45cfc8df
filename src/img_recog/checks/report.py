"""What a check found, as a table."""
from typing import List, NamedTuple, Optional, Sequence

import numpy as np

from img_recog.errors import shortened
from img_recog.formats.audit import Finding

SIMULATED, MEASURED, ASSUMED = 'simulated', 'measured', 'assumed'
NOT_SIMULATED, NOT_DRAWN, LEFT_OUT = 'not simulated', 'not drawn', 'left out'
_HEAD = ('state', 'what', 'value', 'from')
_MAX_WIDTH = 60         # of a column, in characters; what is longer makes only its line longer


class Row(NamedTuple):
    """A line of the table; state: one of the constants above; source: where the value is from."""

    state: str
    what: str
    value: str = ''
    source: str = ''


class Report(NamedTuple):
    """What was found.

    warnings: those that the node logs; problem: why it cannot be used; is_partial: whether
    something that the file asks for is not done.
    """

    title: str
    rows: Sequence[Row]
    warnings: Sequence[str] = ()
    problem: str = ''
    is_partial: bool = False

    def text(self) -> str:
        """Return the title, the table and the warnings, a line each."""
        cells = [tuple(map(shortened, row)) for row in (_HEAD, *self.rows)]
        widths = [max(len(cell) for cell in column if len(cell) <= _MAX_WIDTH)
                  for column in zip(*cells)]
        lines = ['  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip()
                 for row in cells]
        return '\n'.join([self.title, '', *lines,
                          *('warning: ' + warning for warning in self.warnings), ''])


def rows_of(findings: Sequence[Finding]) -> List[Row]:
    """Return a row for each finding of the audit."""
    return [Row(finding.state, finding.what, finding.places_text()) for finding in findings]


def size(box: Optional[np.ndarray]) -> str:
    """Return the size of a box (2, 3), its lowest and highest corner in m; None: not drawn.

    >>> size(np.array([(0, 0, 0), (1, 0.25, 2)]))
    '1 x 0.25 x 2 m'
    """
    if box is None:
        return 'not drawn'
    return ' x '.join('{:.4g}'.format(round(top - bottom, 4))
                      for bottom, top in box.T) + ' m'
