"""A log's ticks as Parquet, through pyarrow; what the log says of its run stands in the schema."""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from reflexarc_logs.reading.reader import Log
from reflexarc_logs.tables.table_file import table_file
from reflexarc_logs.tables.tick_rows import Row, TickTable

GROUP_ROWS = 1 << 14
"""Rows that are in memory at once: five minutes at 50 Hz."""

_TYPES: dict[str, Any] = {
    "uint": pa.uint64(),
    "int": pa.int64(),
    "float": pa.float64(),
    "float32": pa.float32(),
    "text": pa.string(),
    "bytes": pa.binary(),
    "floats": pa.list_(pa.float32()),
}


def write_parquet(log: Log, out: Path | str) -> int:
    """Write the table; returns the number of its rows.

    Raises:
        LogError: the log cannot be read or holds no ticks; `out` exists or cannot be written.
    """
    table = TickTable(log)
    schema = _schema(log, table)
    total = 0
    with (
        table_file(Path(out)) as place,
        pq.ParquetWriter(place, schema, compression="zstd") as file,
    ):
        for rows in _groups(table.rows()):
            columns = zip(*rows, strict=True)
            arrays = [pa.array(c, f.type) for c, f in zip(columns, schema, strict=True)]
            file.write_table(pa.Table.from_arrays(arrays, schema=schema))
            total += len(rows)
    return total


def _schema(log: Log, table: TickTable) -> Any:
    fields = [pa.field(column.name, _TYPES[column.kind]) for column in table.columns]
    about = log.run.to_metadata()
    if table.contract is not None:
        about = {**about, "contract": table.contract.to_json()}
    return pa.schema(fields, metadata={f"reflexarc.{name}": text for name, text in about.items()})


def _groups(rows: Iterator[Row]) -> Iterator[list[Row]]:
    while group := list(islice(rows, GROUP_ROWS)):
        yield group
