"""The fleet at one moment, as plain values: robots in order, their runtimes, their bodies."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from reflexarc_runtime.fleet.said import BodySaid, LeaseSaid, RuntimeSaid
from reflexarc_runtime.fleet.tally import PhaseTally
from reflexarc_runtime.messages.topics import BODY_NODE, RUNTIME_NODE


@dataclass(frozen=True, slots=True)
class RuntimeView:
    """One runtime of a robot."""

    sender: bytes
    """The identifier that its messages carry."""
    said: RuntimeSaid
    age_s: float
    """Since its last status was heard, by the listener's clock."""
    is_silent: bool
    holds_lease: bool
    """Whether a body that is heard obeys it."""
    period_verdicts: Mapping[str, int] | None
    tallies: Mapping[str, PhaseTally] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class BodyView:
    """One body of a robot."""

    sender: bytes
    said: BodySaid
    lease: LeaseSaid | None
    age_s: float
    is_silent: bool


@dataclass(frozen=True, slots=True)
class RobotView:
    """All that is known of one name: as a rule one runtime and one body."""

    robot: str
    nodes: tuple[str, ...]
    """Who announces itself: runtime, body, recorder."""
    runtimes: tuple[RuntimeView, ...]
    bodies: tuple[BodyView, ...]

    @property
    def owes_a_word(self) -> bool:
        """Whether a runtime or a body announces itself that has said nothing."""
        owes_runtime = RUNTIME_NODE in self.nodes and not self.runtimes
        return owes_runtime or (BODY_NODE in self.nodes and not self.bodies)

    @property
    def runtime(self) -> RuntimeView | None:
        """The runtime that stands for the robot: who holds the lease, else who is heard, else any.

        Of several alike, the one whose identifier comes first.
        """
        ranked = sorted(self.runtimes, key=lambda each: (not each.holds_lease, each.is_silent))
        return ranked[0] if ranked else None

    @property
    def body(self) -> BodyView | None:
        """The body that stands for the robot."""
        ranked = sorted(self.bodies, key=lambda each: each.is_silent)
        return ranked[0] if ranked else None


@dataclass(frozen=True, slots=True)
class FleetView:
    """Every robot."""

    robots: tuple[RobotView, ...]
    unreadable: int = 0
    """Messages that no node of ours sends."""
    left_out: int = 0
    """Messages of nodes for which there was no room."""

    @property
    def runtimes(self) -> list[RuntimeView]:
        """Those that are heard."""
        return [each for one in self.robots for each in one.runtimes if not each.is_silent]

    @property
    def bodies(self) -> list[BodyView]:
        """Those that are heard."""
        return [each for one in self.robots for each in one.bodies if not each.is_silent]

    @property
    def silent(self) -> int:
        """Nodes that have fallen silent."""
        runtimes = sum(each.is_silent for one in self.robots for each in one.runtimes)
        return runtimes + sum(each.is_silent for one in self.robots for each in one.bodies)
