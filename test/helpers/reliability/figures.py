"""Tables of what was measured, as Markdown."""
import statistics
from typing import Iterable, List, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """Return a Markdown table with columns of even width."""
    cells = [list(map(str, head))] + [list(map(str, row)) for row in rows]
    widths = [max(len(row[column]) for row in cells) for column in range(len(head))]
    lines = ['| {} |'.format(' | '.join(cell.ljust(width) for cell, width in zip(row, widths)))
             for row in cells]
    lines.insert(1, '|{}|'.format('|'.join('-' * (width + 2) for width in widths)))
    return '\n'.join(lines)


def seconds(values: List[float]) -> List[str]:
    """Return count, median and maximum of some times in seconds."""
    if not values:
        return ['0', '', '']
    return [str(len(values)), '{:.2f}'.format(statistics.median(values)),
            '{:.2f}'.format(max(values))]
