"""Output of commands: one JSON object for programs; tables and progress bars for people."""

import dataclasses
import json
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from math import isfinite
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.progress import Progress
from rich.table import Table

console = Console(highlight=False)
"""Results go to standard output."""

aside = Console(stderr=True, highlight=False)
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


def facts(rows: Mapping[str, object], title: str | None = None, name_width: int = 0) -> Table:
    """A table of names and values; several with one width of the names stand in line."""
    table = Table(title=title, title_justify="left", show_header=False, box=None, pad_edge=False)
    table.add_column(style="bold", no_wrap=True, min_width=name_width or None)
    table.add_column(overflow="fold")
    for name, value in rows.items():
        table.add_row(name, str(value))
    return table


def plain(text: str) -> str:
    """Words from a file, so that they are shown as they are: no markup, no control characters."""
    return escape("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text))


def microseconds(time_ns: int) -> str:
    """A short time with its unit, for people."""
    return f"{time_ns / 1e3:.0f} µs" if time_ns < 1_000_000 else f"{time_ns / 1e6:.1f} ms"


def kibibytes(count: int) -> str:
    """A size with its unit, for people."""
    return f"{count / 1024:.1f} KiB" if count < 1 << 20 else f"{count / (1 << 20):.1f} MiB"


@contextmanager
def progress_bar(title: str, total: int) -> Iterator[Callable[[int, int], None]]:
    """A progress bar on standard error; what it yields is called with (done, total)."""
    with Progress(console=aside, transient=True) as progress:
        task = progress.add_task(title, total=total)
        yield lambda done, of: progress.update(task, completed=done, total=of)
