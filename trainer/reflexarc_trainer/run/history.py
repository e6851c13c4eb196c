"""Validation points of a run: one row each, in metrics.csv and in checkpoints."""

import csv
import io
from collections.abc import Sequence
from typing import NamedTuple

IN_A_ROW = 2
"""Points that must reach the goal, one after another: a single one may be chance."""


class Row(NamedTuple):
    """A validation point."""

    step: int
    seconds: float
    """Wall-clock time of the run, without interruptions."""
    epsilon: float
    mean_abs_error: float
    """Mean of |δ| (online) or of |G − Q| (batched) since the last row."""
    learning_contacts_per_100m: float
    """Contacts while learning, random actions included, since the last row."""
    validation_contacts_per_100m: float
    """Contacts of the greedy policy, on validation worlds."""


def best_of(rows: Sequence[Row]) -> Row | None:
    """The point with the fewest contacts on validation worlds, the first of equals."""
    return min(rows, key=lambda row: row.validation_contacts_per_100m, default=None)


def has_reached(rows: Sequence[Row], goal: float | None) -> bool:
    """Whether the last two points both have at most `goal` contacts per 100 m."""
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
    """Rows from a table of numbers (points, columns), as a checkpoint has them."""
    return [Row(int(step), *rest) for step, *rest in table]
