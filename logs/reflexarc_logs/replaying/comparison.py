"""What a replay found: counts first, then the first divergence, then each flip with its margin.

Rules. With the NumPy backend on both sides values are equal in bits. With onnxruntime on either
side Q-values and memories agree to the contract's `q_tolerance`, and a flip between two actions
whose recorded values lie closer than twice that is rounding; everything else is a divergence.
"""

import dataclasses
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any

from reflexarc_logs.replaying.message_fields import Difference
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.agreement import Q_TOLERANCE

SHOWN_FLIPS = 12

_FOLLOWS_ACTION = (
    "winner",
    "action",
    "command.action",
    "command.linear_mps",
    "command.lateral_mps",
    "command.angular_radps",
)


@dataclass(frozen=True, slots=True)
class Divergence:
    """A field of a tick that is not what was recorded."""

    tick: int
    path: str
    recorded: str
    replayed: str


@dataclass(frozen=True, slots=True)
class Flip:
    """A tick at which another action won."""

    tick: int
    recorded: int
    """Index of the action that was recorded."""
    replayed: int
    margin: float
    """Recorded Q-value of the recorded action, minus that of the replayed one."""
    rounding: bool
    """Whether the margin is within the rounding of two backends; else the behaviour changed."""


@dataclass(frozen=True)
class EqualityRules:
    """What counts as equal."""

    exact: bool
    """Bits; or `tolerance`, because onnxruntime computed one side."""
    same_policy: bool
    """Whether the policy is the one that was recorded."""
    tolerance: float = Q_TOLERANCE
    """The `q_tolerance` of the policy's contract."""

    def judge(self, differences: Iterable[Difference], flip: Flip | None) -> list[Difference]:
        """The differences that count."""
        return [d for d in differences if not self._excused(d, flip)]

    def _excused(self, difference: Difference, flip: Flip | None) -> bool:
        path = difference.path
        if path == "policy_hash" and not self.same_policy:
            return True
        if self.exact:
            return False
        if path.startswith(("q_values[", "state[")):
            recorded, replayed = float(difference.recorded), float(difference.replayed)
            return is_close(recorded, replayed, self.tolerance)
        return flip is not None and flip.rounding and path in _FOLLOWS_ACTION


@dataclass(frozen=True)
class LevelResult:
    """One level of one replay, in numbers."""

    level: str
    """policy or node."""
    ticks: int
    """Ticks in the log."""
    compared: int
    identical: int
    """Equal under the rules."""
    fields_compared: int
    not_compared: tuple[str, ...] = ()
    """Fields that only the log or only this package knows."""
    warming_up: int = 0
    """Ticks at which a candidate with a memory was asked, and that do not count yet."""
    first: Divergence | None = None
    flips: tuple[Flip, ...] = ()


@dataclass(frozen=True)
class ReplayReport:
    """What a replay found."""

    log: str
    policy_hash: str
    same_policy: bool
    recorded_backend: str
    backend: str
    actions: tuple[str, ...]
    levels: tuple[LevelResult, ...]
    notes: tuple[str, ...] = ()
    """What the reader should know: why a level was left out, what was left over."""

    @property
    def exit_status(self) -> int:
        """0: all equal under the rules. 1: different. 2: nothing was compared."""
        if not any(level.compared for level in self.levels):
            return 2
        return int(any(level.identical < level.compared for level in self.levels))

    @property
    def verdict(self) -> str:
        """The exit status in a word."""
        return ("identical", "different", "nothing was compared")[self.exit_status]

    def as_dict(self) -> dict[str, Any]:
        """Everything, for `--json`."""
        head = {"verdict": self.verdict, "exit_status": self.exit_status}
        return {**head, **dataclasses.asdict(self)}

    def lines(self) -> list[str]:
        """A text for people, under 40 lines."""
        return list(self._lines())

    def _lines(self) -> Iterator[str]:
        whose = "the recorded one" if self.same_policy else "another one than recorded"
        yield f"{self.log}: {self.verdict}"
        yield f"  policy {self.policy_hash[:12]}, {whose}"
        yield f"  backend {self.backend}, recorded on {self.recorded_backend}"
        for level in self.levels:
            yield from _level_lines(level, self.actions)
        for note in self.notes:
            yield f"  note: {note}"


@dataclass
class Tally:
    """Counts ticks while a level runs."""

    level: str
    rules: EqualityRules
    ticks: int = 0
    compared: int = 0
    identical: int = 0
    fields_compared: int = 0
    first: Divergence | None = None
    flips: list[Flip] = field(default_factory=list)
    warming_up: int = 0

    def add(
        self, tick: int, fields: int, differences: Iterable[Difference], flip: Flip | None = None
    ) -> None:
        """Count one tick that was compared."""
        counting = self.rules.judge(differences, flip)
        self.compared += 1
        self.fields_compared += fields
        self.identical += not counting
        if flip is not None:
            self.flips.append(flip)
        if counting and self.first is None:
            worst = counting[0]
            self.first = Divergence(tick, worst.path, worst.recorded, worst.replayed)

    def result(self, not_compared: tuple[str, ...] = ()) -> LevelResult:
        """The counts so far."""
        return LevelResult(
            level=self.level,
            ticks=self.ticks,
            compared=self.compared,
            identical=self.identical,
            fields_compared=self.fields_compared,
            not_compared=not_compared,
            first=self.first,
            flips=tuple(self.flips),
            warming_up=self.warming_up,
        )


def find_flip(
    tick: int,
    q_values: Sequence[float],
    recorded: int,
    replayed: int,
    tolerance: float = Q_TOLERANCE,
) -> Flip | None:
    """The flip at a tick, if there is one.

    Args:
        tick: index of the tick.
        q_values: what was recorded, (actions,).
        recorded: index of the action that was recorded.
        replayed: index of the action that won now.
        tolerance: what two backends may differ by.
    """
    last = len(q_values) - 1
    if recorded == replayed or not (0 <= recorded <= last and 0 <= replayed <= last):
        return None
    margin = q_values[recorded] - q_values[replayed]
    allowed = 2 * tolerance * max(1.0, abs(q_values[recorded]))
    return Flip(tick, recorded, replayed, margin, rounding=abs(margin) <= allowed)


def is_at_the_edge(
    q_values: Sequence[float], lead: float, contract: PolicyContract, tolerance: float
) -> bool:
    """Whether a lead is so near to the least one that two backends may see it on either side."""
    edge = max(contract.margin * (max(q_values) - min(q_values)), contract.least_lead)
    return abs(lead - edge) <= 4 * tolerance * max(1.0, *map(abs, q_values))


def is_close(recorded: float, replayed: float, tolerance: float = Q_TOLERANCE) -> bool:
    """Whether two Q-values agree as two backends must; what is not finite, only with itself."""
    if not (math.isfinite(recorded) and math.isfinite(replayed)):
        return recorded == replayed or (math.isnan(recorded) and math.isnan(replayed))
    return abs(replayed - recorded) <= tolerance * max(1.0, abs(recorded))


def _level_lines(level: LevelResult, actions: tuple[str, ...]) -> Iterator[str]:
    yield (
        f"  level {level.level}: {level.ticks} ticks, {level.compared} compared, "
        f"{level.identical} identical; {level.fields_compared} fields"
    )
    if level.warming_up:
        yield f"    not counted: {level.warming_up} ticks in which its memory warms up"
    if level.not_compared:
        yield f"    not compared: {', '.join(level.not_compared)}"
    if level.first is not None:
        at = level.first
        yield f"    first divergence: tick {at.tick}, {at.path}: {at.recorded} → {at.replayed}"
    if level.flips:
        rounding = sum(flip.rounding for flip in level.flips)
        changed = len(level.flips) - rounding
        yield f"    flips: {len(level.flips)} ({rounding} rounding, {changed} behaviour change)"
    for flip in level.flips[:SHOWN_FLIPS]:
        yield f"      {_flip_line(flip, actions)}"
    if len(level.flips) > SHOWN_FLIPS:
        yield f"      … and {len(level.flips) - SHOWN_FLIPS} more"


def _flip_line(flip: Flip, actions: tuple[str, ...]) -> str:
    names = [actions[i] if i < len(actions) else str(i) for i in (flip.recorded, flip.replayed)]
    kind = "rounding" if flip.rounding else "behaviour change"
    return f"tick {flip.tick}: {names[0]} → {names[1]}, margin {flip.margin:.3g}: {kind}"
