"""Statistics of the loop: verdicts, rate and phases, over the run and over the last period."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

from reflexarc_runtime.decision import Decision, Timing, Verdict
from reflexarc_runtime.loop.cadence.phases import PhaseHistograms
from reflexarc_runtime.messages.spread import Spread


@dataclass(frozen=True, slots=True)
class Summary:
    """Statistics of a series of ticks. Counts are since the start of the run."""

    ticks: int
    skipped_slots: int
    """Deadlines that the loop missed."""
    rate_hz: float
    lateness_p50_ns: int
    lateness_p99_ns: int
    lateness_max_ns: int
    verdicts: dict[str, int]
    phases: Mapping[str, Spread] = field(default_factory=dict)
    """How long each phase took."""


@dataclass
class Stretch:
    """Timing of a series of ticks: how far apart they began, and how long their phases took."""

    since_ns: int | None = None
    """When the tick before the first one began; None: there is none, so intervals count from it."""
    last_ns: int = 0
    intervals: int = 0
    phases: PhaseHistograms = field(default_factory=PhaseHistograms)

    def saw(self, decision: Decision, timing: Timing) -> None:
        """Add one tick."""
        if self.since_ns is None:
            self.since_ns = timing.wake_ns
        else:
            self.intervals += 1
        self.last_ns = timing.wake_ns
        self.phases.saw(decision, timing)

    def next(self) -> "Stretch":
        """An empty one, whose first interval begins at the last tick of this one."""
        return Stretch() if self.since_ns is None else Stretch(self.last_ns, self.last_ns)

    def take(self, later: "Stretch") -> None:
        """Add all the ticks of the next one."""
        if later.since_ns is not None:
            self.since_ns = later.since_ns if self.since_ns is None else self.since_ns
            self.last_ns = later.last_ns
            self.intervals += later.intervals
            self.phases.take(later.phases)

    @property
    def rate_hz(self) -> float:
        """Ticks a second; 0 before the second tick."""
        if self.since_ns is None or self.last_ns <= self.since_ns:
            return 0.0
        return self.intervals / ((self.last_ns - self.since_ns) * 1e-9)


@dataclass
class Monitor:
    """Collects the statistics, tick by tick."""

    verdicts: Counter[Verdict] = field(default_factory=Counter)
    skipped_slots: int = 0
    before: Stretch = field(default_factory=Stretch)
    """The run up to the last call of `period`."""
    last_period: Stretch = field(default_factory=Stretch)

    def missed(self, deadlines: int) -> None:
        """Count deadlines that passed without a tick."""
        self.skipped_slots += deadlines

    def saw(self, decision: Decision, timing: Timing) -> None:
        """Count one tick."""
        self.verdicts[decision.verdict] += 1
        self.last_period.saw(decision, timing)

    def ended(self, decision: Decision) -> None:
        """Count the last tick, which ends the run: it has no deadline and no lateness."""
        self.verdicts[decision.verdict] += 1

    def summary(self) -> Summary:
        """The run so far."""
        run = Stretch()
        run.take(self.before)
        run.take(self.last_period)
        return self._summarise(run)

    def period(self) -> Summary:
        """The time since the last call of `period`."""
        summary = self._summarise(self.last_period)
        self.before.take(self.last_period)
        self.last_period = self.last_period.next()
        return summary

    def _summarise(self, stretch: Stretch) -> Summary:
        phases = stretch.phases.spreads()
        lateness = phases.get("lateness", Spread())
        return Summary(
            ticks=self.verdicts.total(),
            skipped_slots=self.skipped_slots,
            rate_hz=stretch.rate_hz,
            lateness_p50_ns=lateness.p50_ns,
            lateness_p99_ns=lateness.p99_ns,
            lateness_max_ns=lateness.max_ns,
            verdicts={verdict.name: count for verdict, count in sorted(self.verdicts.items())},
            phases=phases,
        )
