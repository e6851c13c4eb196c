"""What a node said last, as far as anybody will keep it: texts are cut, lists are bounded.

Times are nanoseconds. Whoever sends on the bus may say any number and any text.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from reflexarc_runtime.messages.spread import Spread
from reflexarc_runtime.messages.wire import NO_SENDER

OTHER = "OTHER"
"""Under which all is counted whose name is not ours."""


@dataclass(frozen=True, slots=True)
class RuntimeSaid:
    """A runtime's status: see `reflexarc.Status`."""

    run_id: str = ""
    rate_hz: float | None = None
    """None: it is no number that a rate could be."""
    contract_rate_hz: float | None = None
    """None: not known."""
    pace: str = ""
    ticks: int = 0
    skipped_slots: int = 0
    inbox_overflows: int = 0
    verdict: str = ""
    """Of the last tick; empty: not known."""
    verdicts: Mapping[str, int] = field(default_factory=dict)
    """Ticks since the start of the run, by verdict."""
    action: str = ""
    """Of the last tick, by name; empty: the safe command."""
    policy: str = ""
    policy_hash: str = ""
    guard: str = ""
    recording: str = ""
    watchdog: str = ""
    sensor: str = ""
    shadow: str = ""
    phases: Mapping[str, Spread] = field(default_factory=dict)
    is_stand_in: bool = False


@dataclass(frozen=True, slots=True)
class BodySaid:
    """A body's status."""

    guard: str = ""
    inbox_overflows: int = 0


@dataclass(frozen=True, slots=True)
class LeaseSaid:
    """Whom a body obeys: see `reflexarc.Lease`."""

    holder: bytes = b""
    epoch: int = 0
    armed: bool = False
    stopped: str = ""
    words: str = ""
    refused: Mapping[str, int] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class Word:
    """One message of a node: who said what about which robot, and when it was heard."""

    robot: str
    sender: bytes = NO_SENDER
    heard_ns: int = 0
    said: RuntimeSaid | BodySaid | LeaseSaid = field(default_factory=BodySaid)
