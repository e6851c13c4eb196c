"""What one tick of the controller says. Plain values: equal inputs give equal decisions."""

from dataclasses import dataclass
from enum import IntEnum

from reflexarc_runtime.contract import Action

SAFE_ACTION = -1
"""Index of the safe command, which is none of the contract's actions."""


class Verdict(IntEnum):
    """Whether the policy may drive at this tick; numbers as in `messages.proto`."""

    OK = 1
    NO_INPUT = 2
    STALE_INPUT = 3
    INVALID_INPUT = 4
    RECOVERING = 5
    POLICY_FAULT = 6
    STOPPED = 7


@dataclass(frozen=True, slots=True)
class Input:
    """The input that a decision rests on."""

    sequence: int
    source_time_ns: int
    """On the sender's clock."""
    received_ns: int
    """On the runtime's monotonic clock."""
    age_ns: int


@dataclass(frozen=True, slots=True)
class Command:
    """What the body is told to do."""

    sequence: int
    action: int
    verdict: Verdict
    linear_mps: float
    lateral_mps: float
    angular_radps: float
    valid_for_ns: int = 0
    source_sequence: int | None = None
    """Echo of the input; none in a safe command, which is always obeyed."""
    source_time_ns: int | None = None

    @property
    def is_safe(self) -> bool:
        """Whether this is the safe command."""
        return self.source_time_ns is None


@dataclass(frozen=True, slots=True)
class Decision:
    """Everything that the controller saw, computed and said at one tick."""

    index: int
    slot: int
    now_ns: int
    inputs: int
    input: Input | None
    retina: bytes
    q_values: tuple[float, ...]
    action: int
    verdict: Verdict
    reason: str
    command: Command
    policy_hash: str


@dataclass(frozen=True, slots=True)
class Timing:
    """How the node fared at one tick; nanoseconds. Never compared at replay."""

    deadline_ns: int
    wake_ns: int
    receive_ns: int
    decide_ns: int
    publish_ns: int
    record_ns: int
    """Handing over the records of the tick before this one."""

    @property
    def lateness_ns(self) -> int:
        """How long after its deadline the tick woke."""
        return self.wake_ns - self.deadline_ns


def safe_command(index: int, verdict: Verdict, safe: Action) -> Command:
    """The contract's safe command, without an echo."""
    return Command(
        index, SAFE_ACTION, verdict, safe.linear_mps, safe.lateral_mps, safe.angular_radps
    )


def drive_command(
    index: int, action: int, motion: Action, echo: Input, valid_for_ns: int
) -> Command:
    """The command for an action that the policy chose, with the echo of its input."""
    return Command(
        sequence=index,
        action=action,
        verdict=Verdict.OK,
        linear_mps=motion.linear_mps,
        lateral_mps=motion.lateral_mps,
        angular_radps=motion.angular_radps,
        valid_for_ns=valid_for_ns,
        source_sequence=echo.sequence,
        source_time_ns=echo.source_time_ns,
    )
