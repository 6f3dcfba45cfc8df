"""Parts of reports in Markdown."""
from typing import List, Sequence


def lines_of_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> List[str]:
    """Return the lines of a table.

    >>> lines_of_table(['a', 'b'], [['1', '2']])
    ['| a | b |', '| --- | --- |', '| 1 | 2 |']
    """
    return ['| {} |'.format(' | '.join(row)) for row in (head, ['---'] * len(head), *rows)]
