"""What a check found, as a table."""
from typing import List, NamedTuple, Sequence

from img_recog.command_line.results import text_table
from img_recog.report import LEFT_OUT, NOTE, Report

SIMULATED, MEASURED = 'simulated', 'measured'
_HEAD = ('state', 'what', 'value', 'from')


class CheckRow(NamedTuple):
    """A line of the table.

    Attributes:
        state: One of the constants above, or the kind of a finding.
        source: Where the value is from.
    """

    state: str
    what: str
    value: str = ''
    source: str = ''


class CheckReport(NamedTuple):
    """What was found.

    warnings: those that the node logs; problem: why it cannot be used; is_partial: whether
    something that the file asks for is not done.
    """

    title: str
    rows: Sequence[CheckRow]
    warnings: Sequence[str] = ()
    problem: str = ''
    is_partial: bool = False

    def text(self) -> str:
        """Return the title, the table and the warnings, a line each."""
        return '\n'.join([self.title, '', *text_table([_HEAD, *self.rows]),
                          *('warning: ' + warning for warning in self.warnings), ''])


def rows_of(report: Report) -> List[CheckRow]:
    """Return a row for each finding that is not only a line.

    A world from which something is left out is refused without a parameter.
    """
    return [CheckRow(each.kind, each.what, each.places(), 'needs allow_partial_world:=true' * (
        each.kind == LEFT_OUT and each.owner.startswith('world ')))
            for each in report.findings if each.kind != NOTE]
