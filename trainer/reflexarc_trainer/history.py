"""What was measured on the way: one row a validation point, in metrics.csv and in a checkpoint."""

import csv
import io
from collections.abc import Sequence
from typing import NamedTuple


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
