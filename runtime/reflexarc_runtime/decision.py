"""Decisions: what the controller returns for one tick, as plain values that can be compared."""

from dataclasses import dataclass
from enum import IntEnum

from reflexarc_runtime.contract.motion import Action

SAFE_ACTION = -1
"""Index that stands for the safe command, which is not among the contract's actions."""
NO_WINNER = -1
"""Index that stands for no action: the policy was not asked, or failed."""


class Verdict(IntEnum):
    """Whether the policy may drive at this tick; numbers as in `messages.proto`."""

    OK = 1
    NO_INPUT = 2
    STALE_INPUT = 3
    INVALID_INPUT = 4
    RECOVERING = 5
    POLICY_FAULT = 6
    STOPPED = 7
    TWO_SOURCES = 8
    OVERRUN = 9
    GUARDED = 10
    STUCK = 11


ASKED = frozenset({Verdict.OK, Verdict.GUARDED, Verdict.STUCK})
"""Verdicts at which the policy was asked and answered."""


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
    """Number of the input that led to it; None in a safe command, which is always obeyed."""
    source_time_ns: int | None = None
    body: bytes = b""
    """Who sent that input: a body obeys only echoes of its own identifier."""

    @property
    def is_safe(self) -> bool:
        """Whether this is the safe command."""
        return self.source_time_ns is None

    @property
    def moves(self) -> bool:
        """Whether it asks for any speed."""
        return (self.linear_mps, self.lateral_mps, self.angular_radps) != (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Decision:
    """Everything that the controller received, computed and decided at one tick."""

    index: int
    slot: int
    now_ns: int
    inputs: int
    input: Input | None
    retina: bytes
    q_values: tuple[float, ...]
    winner: int
    """What the policy preferred; `NO_WINNER` where it was not asked."""
    action: int
    """What is done: the winner, an action that is still held, or what the guard lets it do."""
    verdict: Verdict
    reason: str
    command: Command
    policy_hash: str
    state: tuple[float, ...] = ()
    """What the policy remembered when it was asked; empty without a memory."""


@dataclass(frozen=True, slots=True)
class Timing:
    """How punctual the node was at one tick, in nanoseconds. Never compared at replay."""

    deadline_ns: int
    wake_ns: int
    receive_ns: int
    decide_ns: int
    publish_ns: int
    record_ns: int
    """What handing over the record of the previous tick took, once its message was made and sent;
    below 0: there was none."""

    @property
    def command_ns(self) -> int:
        """From waking until the command was handed to the bus."""
        return self.receive_ns + self.decide_ns + self.publish_ns

    @property
    def lateness_ns(self) -> int:
        """How long after its deadline the tick began."""
        return self.wake_ns - self.deadline_ns


def safe_command(index: int, verdict: Verdict, safe: Action) -> Command:
    """The contract's safe command; it names no input."""
    return Command(
        index, SAFE_ACTION, verdict, safe.linear_mps, safe.lateral_mps, safe.angular_radps
    )


def drive_command(
    index: int,
    action: int,
    motion: Action,
    echo: Input,
    valid_for_ns: int,
    body: bytes = b"",
    verdict: Verdict = Verdict.OK,
    share: float = 1.0,
) -> Command:
    """The command for an action, at a share of its speed; it names the input that led to it."""
    return Command(
        sequence=index,
        action=action,
        verdict=verdict,
        linear_mps=share * motion.linear_mps,
        lateral_mps=share * motion.lateral_mps,
        angular_radps=share * motion.angular_radps,
        valid_for_ns=valid_for_ns,
        source_sequence=echo.sequence,
        source_time_ns=echo.source_time_ns,
        body=body,
    )
