"""The fields in which two messages differ, and by how much."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from reflexarc_logs.diffing.diff_rules import FieldPatterns, FieldTolerance
from reflexarc_logs.diffing.payloads import Value, leaves

ABSENT = "absent"


@dataclass(frozen=True, slots=True)
class Unequal:
    """A field with two values."""

    path: str
    a: Any
    b: Any

    @property
    def apart(self) -> float | None:
        """How far two numbers lie apart; None for what is no number."""
        return _apart(self.a, self.b)


@dataclass(frozen=True, slots=True)
class FieldRules:
    """What counts in the messages of one stream."""

    ignored: FieldPatterns
    tolerances: tuple[FieldTolerance, ...]

    def unequal(self, a: Value, b: Value) -> Iterator[Unequal]:
        """The fields that differ and count, in A's order, then those that only B has."""
        ours, theirs = dict(leaves(a)), dict(leaves(b))
        for path in (*ours, *(p for p in theirs if p not in ours)):
            one = Unequal(path, ours.get(path, ABSENT), theirs.get(path, ABSENT))
            if not (_same(one.a, one.b) or self.ignored.cover(path) or self._tolerates(one)):
                yield one

    def _tolerates(self, one: Unequal) -> bool:
        apart = one.apart
        return apart is not None and any(
            apart <= t.absolute + t.relative * abs(one.a)
            for t in self.tolerances
            if t.fields.cover(one.path)
        )


def _same(a: Any, b: Any) -> bool:
    """Equal, and of one kind: 1 is not true, 0.0 is not -0.0, but one NaN is another."""
    if isinstance(a, float) and isinstance(b, float):
        return (a == b and math.copysign(1, a) == math.copysign(1, b)) or (a != a and b != b)
    return isinstance(a, bool) == isinstance(b, bool) and bool(a == b)


def _apart(a: Any, b: Any) -> float | None:
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in (a, b))
    if not numbers:
        return None
    if a == b:
        return 0.0
    apart = abs(float(a) - float(b)) if max(abs(a), abs(b)) < 2**53 else float(abs(a - b))
    return apart if not math.isnan(apart) else math.inf
