"""Tables of results: CSV, and Parquet where pyarrow is installed."""
import csv
import importlib.util
import io
from typing import IO, Any, Dict, Iterable, Sequence, Tuple

_ARROW = 'pyarrow'


def extensions() -> Tuple[str, ...]:
    """Return the types of files that `write` writes."""
    return ('.csv', '.parquet') if importlib.util.find_spec(_ARROW) else ('.csv',)


def write(files: Sequence[IO[bytes]], columns: Sequence[str],
          rows: Iterable[Dict[str, Any]]) -> None:
    """Write rows to open files, one for each of `extensions`; a missing value is empty."""
    rows = rows if len(files) == 1 else list(rows)
    text = io.TextIOWrapper(files[0], 'utf-8', newline='')      # type: ignore[arg-type]
    writer = csv.DictWriter(text, columns, lineterminator='\n')
    writer.writeheader()
    writer.writerows(rows)
    text.flush()
    text.detach()
    if len(files) > 1:
        import pyarrow
        from pyarrow import parquet
        parquet.write_table(pyarrow.table({
            column: [row.get(column) for row in rows] for column in columns}), files[1])
