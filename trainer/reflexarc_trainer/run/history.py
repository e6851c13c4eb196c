"""What was measured on the way: one row a validation point, in metrics.csv and in a checkpoint."""

import csv
import io
from collections.abc import Sequence
from typing import NamedTuple

IN_A_ROW = 2
"""One point may be luck."""


class Row(NamedTuple):
    """One validation point."""

    step: int
    seconds: float
    """Wall-clock time of the run, interruptions left out."""
    epsilon: float
    mean_abs_error: float
    """Of the TD error (online) or of the λ-return (batched), since the last row."""
    learning_contacts_per_100m: float
    """While learning, random actions included, since the last row."""
    validation_contacts_per_100m: float
    """Greedy, on validation worlds."""


def best_of(rows: Sequence[Row]) -> Row | None:
    """The point with the fewest contacts on validation worlds, the first of equals."""
    return min(rows, key=lambda row: row.validation_contacts_per_100m, default=None)


def has_reached(rows: Sequence[Row], goal: float | None) -> bool:
    """Whether the last two points are both at or below a goal in contacts per 100 m."""
    last = [row.validation_contacts_per_100m for row in rows[-IN_A_ROW:]]
    return goal is not None and len(last) == IN_A_ROW and all(score <= goal for score in last)


def to_csv(rows: Sequence[Row]) -> bytes:
    """The rows as a table with a header."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(Row._fields)
    table.writerows([row.step, *(f"{value:.6g}" for value in row[1:])] for row in rows)
    return text.getvalue().encode()


def from_table(table: Sequence[Sequence[float]]) -> list[Row]:
    """Rows from plain numbers, as a checkpoint keeps them."""
    return [Row(int(step), *rest) for step, *rest in table]
