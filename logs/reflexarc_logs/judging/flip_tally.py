"""Counts the flips of a candidate on one log, and keeps those of the largest margins."""

import heapq
from collections import Counter
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from reflexarc_logs.judging.amounts import amount
from reflexarc_logs.judging.answers import Answers, JudgedTick
from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.judgement import NO_ACTION, JudgedFlip
from reflexarc_logs.judging.opposites import opposites
from reflexarc_logs.replaying.comparison import EqualityRules, find_flip
from reflexarc_logs.replaying.report import Flip
from reflexarc_runtime.arrays import QValues
from reflexarc_runtime.contract.motion import Action

MOST_KEPT = 200
"""Flips of a log that are kept whole; the others are counted."""
MOST_KEPT_BYTES = 1 << 20
"""And bytes of their retinas: a camera's have tens of KiB each."""


class FlipTally:
    """The flips of one log.

    Args:
        limits: which flips count.
        rules: what two backends may differ by.
        actions: of the contract.
        has_winner: whether the ticks say what was preferred; before, it was always what was done.
    """

    def __init__(
        self,
        limits: FlipLimits,
        rules: EqualityRules,
        actions: Sequence[Action],
        *,
        has_winner: bool,
    ) -> None:
        self._limits, self._rules, self._has_winner = limits, rules, has_winner
        self._opposite = opposites(actions)
        self._every = np.ones(len(actions), np.int64)
        self._kept: list[tuple[float, int, JudgedFlip]] = []
        self.counts: Counter[str] = Counter()
        """By the name of a field of `LogJudgement`."""
        self._largest_margin = 0.0
        self._first: tuple[int, float] | None = None

    def add(self, answers: Answers) -> None:
        """Count a batch."""
        recorded = np.array(self.preferred(answers))
        inside = np.array([tick.counts for tick in answers.ticks]) & (recorded >= 0)
        if not answers.is_warm:
            self.counts["warming_up"] += int(inside.sum())
            return
        is_finite = np.isfinite(answers.q_values) @ self._every == len(self._every)
        self.counts["ticks"] += int(inside.sum())
        self.counts["faults"] += int((inside & ~is_finite).sum())
        for row in np.flatnonzero(inside & is_finite & (recorded != answers.winners)).tolist():
            now = int(answers.winners[row])
            self._flip(answers.ticks[row], int(recorded[row]), now, answers.q_values[row])

    def preferred(self, answers: Answers) -> list[int]:
        """The actions that the recorded policy preferred; `NO_ACTION`: none."""
        decisions, most = [tick.decision for tick in answers.ticks], len(self._every)
        found = [d.winner for d in decisions] if self._has_winner else [d.action for d in decisions]
        return [index if index < most else NO_ACTION for index in found]

    def result(self) -> dict[str, Any]:
        """What was counted, by the fields of `LogJudgement`."""
        found = sorted(self._kept, key=lambda one: -one[1])
        kept = tuple(flip for _, _, flip in found)
        first_tick, first_s = self._first or (NO_ACTION, 0.0)
        return {
            **self.counts,
            "broken": tuple(self._broken()),
            "largest_margin": self._largest_margin,
            "first_tick": first_tick,
            "first_s": first_s,
            "shown_flips": kept,
            "more_flips": self.counts["flips"] - len(kept),
        }

    def _broken(self) -> Iterator[str]:
        """Which limits are exceeded."""
        counts = self.counts
        yield from self._limits.exceeded(counts["flips"], counts["reversals"], counts["ticks"])
        if faults := counts["faults"]:
            at = amount(faults, "tick")
            yield f"its Q-values are not finite at {at}: the loop would stop"

    def _flip(self, tick: JudgedTick, was: int, now: int, values: QValues) -> None:
        decision = tick.decision
        rules, recorded = self._rules, decision.q_values
        flip = find_flip(decision.index, recorded, was, now, rules.tolerance)
        assert flip is not None  # both are actions, and not the same
        if flip.rounding and not rules.exact:
            self.counts["rounding"] += 1
            return
        if flip.margin < self._limits.margin and self._limits.margin > 0.0:
            self.counts["below_margin"] += 1
            return
        self.counts["flips"] += 1
        self.counts["reversals"] += bool(self._opposite[was, now])
        self._largest_margin = max(self._largest_margin, flip.margin)
        if self._first is None:
            self._first = decision.index, tick.after_ns / 1e9
        key = flip.margin, -self.counts["flips"]
        room = min(MOST_KEPT, max(1, MOST_KEPT_BYTES // max(1, len(decision.retina))))
        if len(self._kept) < room:
            heapq.heappush(self._kept, (*key, self._judged(tick, flip, values)))
        elif key > self._kept[0][:2]:
            heapq.heapreplace(self._kept, (*key, self._judged(tick, flip, values)))

    def _judged(self, tick: JudgedTick, flip: Flip, values: QValues) -> JudgedFlip:
        decision, was, now = tick.decision, flip.recorded, flip.replayed
        return JudgedFlip(
            tick=decision.index,
            time_s=tick.after_ns / 1e9,
            recorded=was,
            candidate=now,
            margin=flip.margin,
            candidate_margin=float(values[now]) - float(values[was]),
            is_reversal=bool(self._opposite[was, now]),
            recorded_q_values=tuple(decision.q_values),
            candidate_q_values=tuple(values.tolist()),
            retina=decision.retina,
        )
