"""The phases of a tick: how long each of them took, over many ticks."""

from collections.abc import Mapping

from reflexarc_runtime.decision import Decision, Timing
from reflexarc_runtime.loop.cadence.histogram import ABSENT, Histogram, add_each
from reflexarc_runtime.messages.spread import Spread

PHASES = (
    "lateness",
    "receive",
    "decide",
    "publish",
    "record",
    "waking to command",
    "picture age",
)
"""As they are shown; lateness is how long after it was due a tick began."""


class PhaseHistograms:
    """One histogram for each phase."""

    def __init__(self) -> None:
        self._histograms = tuple(Histogram() for _ in PHASES)

    def saw(self, decision: Decision, timing: Timing) -> None:
        """Add one tick. A picture has an age where it led to a command that drives."""
        used, waited_ns = decision.input, timing.decide_ns + timing.publish_ns
        times_ns = (
            timing.lateness_ns,
            timing.receive_ns,
            timing.decide_ns,
            timing.publish_ns,
            timing.record_ns,
            timing.command_ns,
            ABSENT if used is None or decision.command.is_safe else used.age_ns + waited_ns,
        )
        add_each(times_ns, self._histograms)

    def take(self, other: "PhaseHistograms") -> None:
        """Add all the ticks of another one."""
        for mine, theirs in zip(self._histograms, other._histograms, strict=True):
            mine.take(theirs)

    def spreads(self) -> Mapping[str, Spread]:
        """What they say, by phase; without the phases that never were."""
        spreads = (histogram.spread() for histogram in self._histograms)
        return {name: each for name, each in zip(PHASES, spreads, strict=True) if each.count}
