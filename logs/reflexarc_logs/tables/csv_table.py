"""A log's ticks as CSV: RFC 4180, UTF-8, a header; what a tick does not have is empty.

Numbers are written with as many digits as bring back the same bits. A retina is hexadecimal, a
policy's memory is numbers divided by blanks.
"""

import csv
from pathlib import Path
from typing import Any

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.tables.table_file import table_file
from reflexarc_logs.tables.tick_rows import Column, Kind, TickTable

_FLOAT32_DIGITS = 9
"""Digits after which a float32 comes back as it was."""


def write_csv(log: Log, out: Path | str) -> int:
    """Write the table; returns the number of its rows.

    Raises:
        LogError: the log cannot be read or holds no ticks; `out` exists or cannot be written.
    """
    table, rows = TickTable(log), 0
    with table_file(Path(out)) as place, place.open("x", encoding="utf-8", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(column.name for column in table.columns)
        for row in table.rows():
            cells = zip(table.columns, row, strict=True)
            writer.writerow([_text(column, value) for column, value in cells])
            rows += 1
    return rows


def _text(column: Column, value: Any) -> str:
    if value is None:
        return ""
    kind: Kind = column.kind
    if kind == "bytes":
        return str(value.hex())
    if kind == "float32":
        return f"{value:.{_FLOAT32_DIGITS}g}"
    if kind == "floats":
        return " ".join(f"{number:.{_FLOAT32_DIGITS}g}" for number in value)
    return str(value)
