"""What a log can be exported as."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from pathlib import Path


def export_log(kind: str, log: Path, out: Path) -> Mapping[str, object]:
    """Export a log; what was written, by name.

    Raises:
        LogError: the log cannot be read, or `out` exists or cannot be written.
    """
    return EXPORTS[kind](log, out)


def _to_bag(log: Path, out: Path) -> Mapping[str, object]:
    from reflexarc_logs.bags.bag_export import export_bag
    from reflexarc_logs.reading.reader import read_log

    return asdict(export_bag(read_log(log), out))


def _to_parquet(log: Path, out: Path) -> Mapping[str, object]:
    from reflexarc_logs.reading.reader import read_log
    from reflexarc_logs.tables.parquet_table import write_parquet

    return {"log": log, "table": out, "ticks": write_parquet(read_log(log), out)}


def _to_csv(log: Path, out: Path) -> Mapping[str, object]:
    from reflexarc_logs.reading.reader import read_log
    from reflexarc_logs.tables.csv_table import write_csv

    return {"log": log, "table": out, "ticks": write_csv(read_log(log), out)}


EXPORTS: Mapping[str, Callable[[Path, Path], Mapping[str, object]]] = {
    "ros2bag": _to_bag,
    "parquet": _to_parquet,
    "csv": _to_csv,
}
"""By the word that stands in front of the log."""
