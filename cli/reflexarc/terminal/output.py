"""Output of commands: one JSON object for programs; tables and progress bars for people."""

import dataclasses
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from math import isfinite
from pathlib import PurePath
from typing import TYPE_CHECKING, Any

from reflexarc.terminal.plain_console import PlainConsole
from reflexarc_runtime.words.shown import plain

if TYPE_CHECKING:
    from rich.table import Table

__all__ = [
    "aside",
    "console",
    "facts",
    "kibibytes",
    "microseconds",
    "plain",
    "print_json",
    "progress_bar",
]

console = PlainConsole()
"""Results go to standard output."""

aside = PlainConsole(stderr=True)
"""Progress and notices go to standard error."""


def print_json(value: Any) -> None:
    """One JSON object on one line; dataclasses become objects."""
    plain = dataclasses.asdict(value) if dataclasses.is_dataclass(value) else value  # type: ignore[arg-type]  # an instance
    print(json.dumps(_finite(plain), default=str, allow_nan=False))


def _finite(value: Any) -> Any:
    """The same with null where a number is none, or without end: JSON has neither."""
    if isinstance(value, float):
        return value if isfinite(value) else None
    if isinstance(value, Mapping):
        return {key: _finite(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(each) for each in value]
    return value


def facts(rows: Mapping[str, object], title: str | None = None, name_width: int = 0) -> "Table":
    """A table of names and values; several with one width of the names stand in line."""
    from rich.table import Table  # with its bars and boxes, which a loop has no time for

    table = Table(title=title, title_justify="left", show_header=False, box=None, pad_edge=False)
    table.add_column(style="bold", no_wrap=True, min_width=name_width or None)
    table.add_column(overflow="fold")
    for name, value in rows.items():
        table.add_row(name, plain(str(value)) if isinstance(value, PurePath) else str(value))
    return table


def microseconds(time_ns: int) -> str:
    """A short time with its unit, for people."""
    return f"{time_ns / 1e3:.0f} µs" if time_ns < 1_000_000 else f"{time_ns / 1e6:.1f} ms"


def kibibytes(count: int) -> str:
    """A size with its unit, for people."""
    return f"{count / 1024:.1f} KiB" if count < 1 << 20 else f"{count / (1 << 20):.1f} MiB"


@contextmanager
def progress_bar(title: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on standard error; what it yields is called with (done, total)."""
    from rich.progress import (
        BarColumn,
        Progress,
        TaskProgressColumn,
        TextColumn,
        TimeRemainingColumn,
    )

    columns = TextColumn("{task.description}", markup=False), BarColumn(), TaskProgressColumn()
    with Progress(*columns, TimeRemainingColumn(), console=aside, transient=True) as progress:
        task = progress.add_task(title, total=total)
        yield lambda done, of: progress.update(task, completed=done, total=of)
