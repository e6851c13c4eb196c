"""What counts as equal, and the counts while a level runs.

Rules. With the NumPy backend on both sides values are equal in bits. With onnxruntime on either
side Q-values and memories agree to the contract's `q_tolerance`, and a flip between two actions
whose recorded values lie closer than twice that is rounding; everything else is a divergence.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from reflexarc_logs.replaying.message_fields import Difference
from reflexarc_logs.replaying.report import Divergence, Flip, LevelResult
from reflexarc_runtime.arrays import QValues
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.agreement import Q_TOLERANCE

MOST_FLIPS = 10_000
"""So many are kept; the others are counted."""

_FOLLOWS_ACTION = (
    "winner",
    "action",
    "command.action",
    "command.linear_mps",
    "command.lateral_mps",
    "command.angular_radps",
)


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
    more_flips: int = 0
    rounding_flips: int = 0
    warming_up: int = 0
    robot: str = ""
    """Of another robot than the one that the log names."""

    def add(
        self, tick: int, fields: int, differences: Sequence[Difference], flip: Flip | None = None
    ) -> None:
        """Count one tick that was compared."""
        counting = self.rules.judge(differences, flip) if differences else []
        self.compared += 1
        self.fields_compared += fields
        self.identical += not counting
        if flip is not None:
            self._count_flip(flip)
        if counting and self.first is None:
            worst = counting[0]
            self.first = Divergence(tick, worst.path, worst.recorded, worst.replayed)

    def add_alike(self, compared: int, fields: int, identical: int) -> None:
        """Count ticks that were compared; of those that differ, one was added before."""
        self.compared += compared
        self.fields_compared += compared * fields
        self.identical += identical

    def _count_flip(self, flip: Flip) -> None:
        self.rounding_flips += flip.rounding
        if len(self.flips) < MOST_FLIPS:
            self.flips.append(flip)
        else:
            self.more_flips += 1

    def result(
        self, not_compared: tuple[str, ...] = (), given: tuple[str, ...] = ()
    ) -> LevelResult:
        """The counts so far; and see `LevelResult`."""
        return LevelResult(
            level=self.level,
            ticks=self.ticks,
            compared=self.compared,
            identical=self.identical,
            fields_compared=self.fields_compared,
            not_compared=not_compared,
            given=given,
            first=self.first,
            flips=tuple(self.flips),
            more_flips=self.more_flips,
            rounding_flips=self.rounding_flips,
            warming_up=self.warming_up,
            robot=self.robot,
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


def are_close(
    recorded: QValues, replayed: QValues, tolerance: float = Q_TOLERANCE
) -> npt.NDArray[np.bool_]:
    """`is_close` of every value."""
    old, new = recorded.astype(np.float64), replayed.astype(np.float64)
    with np.errstate(invalid="ignore"):
        close = np.abs(new - old) <= tolerance * np.maximum(1.0, np.abs(old))
    same = (old == new) | (np.isnan(old) & np.isnan(new))
    return np.where(np.isfinite(old) & np.isfinite(new), close, same)
