"""The fields in which two messages differ, and by how much."""

import itertools
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from reflexarc_logs.diffing.diff_rules import FieldPatterns, FieldTolerance
from reflexarc_logs.diffing.plain_values import Differing


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

    def counting(self, found: Iterable[Differing]) -> Iterator[Unequal]:
        """Those of the differences that count."""
        for one in itertools.starmap(Unequal, found):
            if not (self.ignored.cover(one.path) or self._tolerates(one)):
                yield one

    def _tolerates(self, one: Unequal) -> bool:
        if not self.tolerances or (apart := one.apart) is None:
            return False
        return any(
            apart <= t.absolute + t.relative * abs(one.a)
            for t in self.tolerances
            if t.fields.cover(one.path)
        )


def _apart(a: Any, b: Any) -> float | None:
    numbers = all(isinstance(v, int | float) and not isinstance(v, bool) for v in (a, b))
    if not numbers:
        return None
    if a == b:
        return 0.0
    apart = abs(float(a) - float(b)) if max(abs(a), abs(b)) < 2**53 else float(abs(a - b))
    return apart if not math.isnan(apart) else math.inf
