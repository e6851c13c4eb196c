"""Statistics of the loop: verdicts, rate and lateness, over the run and over the last period."""

from collections import Counter, deque
from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from reflexarc_runtime.decision import Decision, Timing, Verdict

REMEMBERED_TICKS = 1 << 16
"""Ticks from which percentiles are computed: the last ones, so that memory stays bounded."""


@dataclass(frozen=True, slots=True)
class Summary:
    """Statistics of a series of ticks. Counts are since the start of the run."""

    ticks: int
    skipped_slots: int
    rate_hz: float
    lateness_p50_ns: int
    lateness_p99_ns: int
    lateness_max_ns: int
    verdicts: dict[str, int]


@dataclass
class Stretch:
    """Timing of a series of ticks: when they began, and how late."""

    first_ns: int = 0
    last_ns: int = 0
    ticks: int = 0
    lateness_ns: deque[int] = field(default_factory=lambda: deque(maxlen=REMEMBERED_TICKS))

    def saw(self, timing: Timing) -> None:
        """Add one tick."""
        self.first_ns = self.first_ns if self.ticks else timing.wake_ns
        self.last_ns = timing.wake_ns
        self.ticks += 1
        self.lateness_ns.append(timing.lateness_ns)

    @property
    def rate_hz(self) -> float:
        """Ticks a second; 0 before the second tick."""
        seconds = (self.last_ns - self.first_ns) * 1e-9
        return (self.ticks - 1) / seconds if seconds > 0 else 0.0


@dataclass
class Monitor:
    """Collects the statistics, tick by tick."""

    verdicts: Counter[Verdict] = field(default_factory=Counter)
    run: Stretch = field(default_factory=Stretch)
    last_period: Stretch = field(default_factory=Stretch)
    last_slot: int = 0

    def saw(self, decision: Decision, timing: Timing) -> None:
        """Count one tick. The last one, which ends the run, has no deadline and no lateness."""
        self.verdicts[decision.verdict] += 1
        if decision.verdict is Verdict.STOPPED:
            return
        self.last_slot = decision.slot
        self.run.saw(timing)
        self.last_period.saw(timing)

    @property
    def skipped_slots(self) -> int:
        """Deadlines for which there was no tick."""
        return max(0, self.last_slot - self.run.ticks)

    def summary(self) -> Summary:
        """The run so far."""
        return self._summarise(self.run)

    def period(self) -> Summary:
        """The time since the last call of `period`."""
        summary = self._summarise(self.last_period)
        self.last_period = Stretch()
        return summary

    def _summarise(self, stretch: Stretch) -> Summary:
        p50_ns, p99_ns, worst_ns = _percentiles(stretch.lateness_ns)
        return Summary(
            ticks=self.verdicts.total(),
            skipped_slots=self.skipped_slots,
            rate_hz=stretch.rate_hz,
            lateness_p50_ns=p50_ns,
            lateness_p99_ns=p99_ns,
            lateness_max_ns=worst_ns,
            verdicts={verdict.name: count for verdict, count in sorted(self.verdicts.items())},
        )


def _percentiles(values: Iterable[int]) -> tuple[int, int, int]:
    p50, p99, worst = np.percentile(list(values) or [0], [50, 99, 100])
    return int(p50), int(p99), int(worst)
