"""Was a robot told to stand in time, and did it stand? Judged from what its witness heard.

A robot that is told later than its bound may blame the machine for no more than there is evidence
of, between the end and that moment: what a witness overslept (`witness.py`), or how long the
robot's processes were ready to run while others ran, by the kernel's account (`lives.waited_ns`).
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from campaigns.ends.witness import Overslept, overslept_ns

BRAKING_MS = 500.0
"""From 1 m/s to standstill at 2 m/s², whatever a robot is told."""
LOOKS_MS = 30.0
"""A body shows where it is every 20 ms, and stands a step after that."""
_MS = 1_000_000


@dataclass
class Outcome:
    """One end of one drive."""

    kind: str
    bound_ms: float | None
    robot: int
    ended_ns: int = 0
    """On the wall clock."""
    told_ms: float | None = None
    """From the end to the first word to stand; infinite: none came; None: none was due."""
    stand_ms: dict[str, float] = field(default_factory=dict)
    """From the end to standstill, by base."""
    rolled_mm: dict[str, float] = field(default_factory=dict)
    waited_ms: float = 0.0
    """How long its processes waited for a core, from the end to that word."""
    lived_ms: float = 0.0
    """How long the process that ended had been ready."""
    log: str = ""
    """Of the runtime that ended so."""
    failures: list[str] = field(default_factory=list)
    """What must never be."""


@dataclass(frozen=True)
class Judgement:
    """What is to say about one end that was over its bound."""

    over_ms: float
    overslept_ms: float
    """What there is evidence of in that time."""

    @property
    def is_the_machine_s(self) -> bool:
        """Whether the machine alone made it late."""
        return self.over_ms <= self.overslept_ms

    def __str__(self) -> str:
        return f"{self.over_ms:.1f} ms over, {self.overslept_ms:.1f} ms overslept by the machine"


def judged(outcome: Outcome, seen: Sequence[Overslept]) -> Judgement | None:
    """What is to say about an end; None: it kept its bound, or none is promised."""
    if outcome.bound_ms is None:
        return None
    over_ms, late_ms = _over_ms(outcome)
    if over_ms <= 0.0:
        return None
    if late_ms == math.inf:
        return Judgement(math.inf, 0.0)
    until_ns = outcome.ended_ns + round(late_ms * _MS)
    witnessed_ms = overslept_ns(seen, outcome.ended_ns, until_ns) / _MS
    return Judgement(over_ms, max(witnessed_ms, outcome.waited_ms))


def _over_ms(outcome: Outcome) -> tuple[float, float]:
    """By how much the worst of its times is over its bound, and that time."""
    assert outcome.bound_ms is not None
    times = [(outcome.told_ms, outcome.bound_ms)]
    standing_ms = outcome.bound_ms + BRAKING_MS + LOOKS_MS
    times += [(time_ms, standing_ms) for time_ms in outcome.stand_ms.values()]
    return max(((t - bound, t) for t, bound in times if t is not None), default=(0.0, 0.0))
