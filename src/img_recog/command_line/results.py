"""How results are written: tables as text, Markdown, CSV and Parquet, and pictures."""
import contextlib
import csv
import importlib.util
import io
from typing import (IO, TYPE_CHECKING, Any, Callable, Iterable, Iterator, List, Mapping,
                    NamedTuple, Sequence, Tuple)

from img_recog.errors import shortened

if TYPE_CHECKING:       # it takes long to load, and few programs draw
    from matplotlib.figure import Figure

_ARROW, _DPI = 'pyarrow', 100
_MAX_WIDTH = 60     # of a column, in characters; what is longer makes only its line longer


class Table(NamedTuple):
    """Columns and rows; what a row does not have, or is None, is an empty cell."""

    columns: Sequence[str]
    rows: Iterable[Mapping[str, Any]]


def text_table(rows: Iterable[Sequence[str]]) -> List[str]:
    """Return the lines of a table with columns.

    >>> text_table([('what', 'value'), ('mass', '1 kg')])
    ['what  value', 'mass  1 kg']
    """
    cells = [tuple(map(shortened, row)) for row in rows]
    widths = [max(len(cell) for cell in column if len(cell) <= _MAX_WIDTH)
              for column in zip(*cells)]
    return ['  '.join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip()
            for row in cells]


def markdown_table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> List[str]:
    """Return the lines of a table in Markdown.

    >>> markdown_table(['a', 'b'], [['1', '2']])
    ['| a | b |', '| --- | --- |', '| 1 | 2 |']
    """
    return ['| {} |'.format(' | '.join(row)) for row in (head, ['---'] * len(head), *rows)]


def markdown_part(text: str, head: Sequence[str], rows: Iterable[Sequence[str]]) -> List[str]:
    """Return the lines of a table below a line of text; none for a table without rows."""
    rows = list(rows)
    return ['', text, '', *markdown_table(head, rows)] if rows else []


def report_extensions() -> Tuple[str, ...]:
    """Return the types of files that `write_report` writes.

    The table is CSV, and Parquet where pyarrow is installed.
    """
    table = ('.csv', '.parquet') if importlib.util.find_spec(_ARROW) else ('.csv',)
    return (*table, '.md', '.png')


def write_report(files: Sequence[IO[bytes]], table: Table, text: str,
                 draw: Callable[[IO[bytes]], None]) -> None:
    """Write a report to open files, one for each of `report_extensions`.

    text: in Markdown; draw: writes the picture.
    """
    *tables, report, picture = files
    _write_table(tables, table)
    report.write(text.encode())
    draw(picture)


@contextlib.contextmanager
def csv_table(file: IO[bytes], columns: Sequence[str]) -> Iterator[Any]:
    """Write the head of a CSV table to an open file; yield a csv.writer for its rows."""
    text = io.TextIOWrapper(file, 'utf-8', newline='',      # type: ignore[arg-type]
                            write_through=True)
    try:
        rows = csv.writer(text, lineterminator='\n')
        rows.writerow(columns)
        yield rows
    finally:
        text.detach()


def _write_table(files: Sequence[IO[bytes]], table: Table) -> None:
    columns, rows = table
    rows = rows if len(files) == 1 else list(rows)
    with csv_table(files[0], columns) as written:
        written.writerows([row.get(column) for column in columns] for row in rows)
    if len(files) > 1:
        import pyarrow
        from pyarrow import parquet
        parquet.write_table(pyarrow.table({
            column: [row.get(column) for row in rows] for column in columns}), files[1])


@contextlib.contextmanager
def picture(file: IO[bytes], size_in: Tuple[float, float], font_size: float = 9.0
            ) -> Iterator['Figure']:
    """Yield an empty figure, and write it as PNG at the end of the `with`.

    It does not depend on the user's matplotlibrc, and has the same bytes by each version of
    matplotlib that draws the same.
    """
    import matplotlib
    from matplotlib.figure import Figure
    with matplotlib.rc_context({**matplotlib.rcParamsDefault, 'font.size': font_size}):
        figure = Figure(figsize=size_in, dpi=_DPI)
        yield figure
        figure.savefig(file, format='png', metadata={'Software': None})
