"""What is asked of moments of a log that are driven again, and what is found, as data."""

from dataclasses import dataclass
from pathlib import Path

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.body.driving_on import DrivenWay


@dataclass(frozen=True)
class Tried:
    """An incident that was driven again."""

    tick: int
    is_contact: bool
    """Whether something was touched there when it was recorded."""
    lead_s: float
    """How long before it both take over."""
    driven_s: float
    recorded: DrivenWay
    candidate: DrivenWay
    recorded_tick: int | None
    """The tick at which the recorded policy touches something now; None: it does not."""
    candidate_tick: int | None
    leaves_tick: int | None
    """From where on the recorded policy's way is not the recorded one; None: it is, up to the
    incident."""
    leaves_m: float
    """By how much, at most."""

    @property
    def is_avoided(self) -> bool:
        """Whether the candidate touches nothing."""
        return self.candidate_tick is None


@dataclass(frozen=True)
class DrivenLog:
    """A log whose incidents were driven again."""

    log: Path
    problem: str = ""
    """Why no moment of it could be rebuilt; empty: it could."""
    world: str = ""
    seed: int = 0
    tried: tuple[Tried, ...] = ()
    too_late: tuple[int, ...] = ()
    """Ticks of contacts that are not tried: they begin too shortly behind another one."""
    off_tick: int | None = None
    """From where on the body, told what it was told, is not where it was; None: it always is."""
    off_m: float = 0.0

    @property
    def avoided(self) -> int:
        """At how many of the incidents that were tried the candidate touches nothing."""
        return sum(one.is_avoided for one in self.tried)


@dataclass(frozen=True)
class WantedDrives:
    """Which incidents are driven again, and how far."""

    at: int | None = None
    """This tick alone."""
    first: bool = False
    """The first contact alone."""
    before_s: float = 2.0
    driven_s: float = 5.0

    def __post_init__(self) -> None:
        for name, value in (("--before", self.before_s), ("--driven", self.driven_s)):
            if not 0.0 < value <= 600.0:
                raise UsageError(f"{name}: expected above 0 and at most 600 s, got {value}")
        if self.at is not None and self.first:
            raise UsageError("expected --at or --first, got both")
