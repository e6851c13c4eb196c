"""What is remembered of one runtime, and of one body."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from reflexarc_runtime.fleet.said import BodySaid, LeaseSaid, RuntimeSaid
from reflexarc_runtime.fleet.tally import PhaseTally

SILENT_NS = 3_000_000_000
"""A node says something every second: after three without a word it is silent."""
_MOST_TALLIES = 16
GONE_NS = 30_000_000_000
"""A node that has been silent for so long is forgotten."""


@dataclass
class RuntimeHeard:
    """One runtime, by its statuses."""

    said: RuntimeSaid
    heard_ns: int
    period_verdicts: Mapping[str, int] | None = None
    """Ticks between its last two statuses, by verdict; None: there was one only."""
    tallies: dict[str, PhaseTally] = field(default_factory=dict)
    """Times of the phases since the first status that was heard, by phase."""

    def hear(self, said: RuntimeSaid, heard_ns: int) -> None:
        """Take another status; of a stand-in, only what it knows."""
        self.heard_ns = heard_ns
        if said.is_stand_in:
            self.said = replace(
                self.said,
                watchdog=said.watchdog,
                verdict=said.verdict,
                action="",
                is_stand_in=True,
            )
            return
        before = self.said.verdicts
        self.period_verdicts = {
            name: count - before.get(name, 0)
            for name, count in said.verdicts.items()
            if count > before.get(name, 0)
        }
        self.said = said
        self.count()

    def count(self) -> None:
        """Add the times of the status's period."""
        for name, spread in self.said.phases.items():
            if name in self.tallies or len(self.tallies) < _MOST_TALLIES:
                self.tallies.setdefault(name, PhaseTally()).add(spread)


@dataclass
class BodyHeard:
    """One body, by its statuses and its lease."""

    heard_ns: int
    said: BodySaid = field(default_factory=BodySaid)
    lease: LeaseSaid | None = None
    """None: none was heard yet."""

    def hear(self, said: BodySaid | LeaseSaid, heard_ns: int) -> None:
        """Take what it says."""
        self.heard_ns = heard_ns
        if isinstance(said, BodySaid):
            self.said = said
        else:
            self.lease = said
