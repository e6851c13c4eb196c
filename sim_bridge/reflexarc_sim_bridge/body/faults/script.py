"""Fault scripts: what goes wrong between a body's eye and the bus, and when. Data only.

Times are seconds since the body's first retina. `script_file` reads a script from a file,
`random_script` draws one from a seed, `faulty_stream` applies it.
"""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, TypeAlias

from reflexarc_runtime.config.annotations import arms_of
from reflexarc_runtime.config.checks import require


class Frozen(StrEnum):
    """What repeats while a sender is frozen."""

    IMAGE = "image"
    """The picture; numbers and times go on."""
    SEQUENCE = "sequence"
    """The sequence number; pictures and times go on."""
    TIME = "time"
    """The source time; pictures and numbers go on."""
    MESSAGE = "message"
    """Everything: the same bytes again and again."""


class Malformation(StrEnum):
    """What makes a message unusable."""

    NOT_PROTOBUF = "not-protobuf"
    EMPTY = "empty"
    TRUNCATED = "truncated"
    WRONG_SIZE = "wrong-size"
    WRONG_PIXELS = "wrong-pixels"
    """Another pixel encoding."""
    WRONG_CHANNELS = "wrong-channels"
    WRONG_ENCODING = "wrong-encoding"
    """Another payload encoding on the bus."""
    NO_ATTACHMENT = "no-attachment"
    SHORT_ATTACHMENT = "short-attachment"
    HUGE_ATTACHMENT = "huge-attachment"
    NEGATIVE_STAMP = "negative-stamp"
    HUGE_PAYLOAD = "huge-payload"
    """Two MiB that are not protobuf."""
    HUGE_TEXT = "huge-text"
    """A picture whose pixel encoding is a text of almost one MiB."""


@dataclass(frozen=True)
class Delay:
    """Every message is late by the same time."""

    begin_s: float
    duration_s: float
    delay_s: float


@dataclass(frozen=True)
class Jitter:
    """Every message is late by 0 to `jitter_s`; some overtake others."""

    begin_s: float
    duration_s: float
    jitter_s: float


@dataclass(frozen=True)
class Loss:
    """A share of the messages is lost."""

    begin_s: float
    duration_s: float
    share: float


@dataclass(frozen=True)
class Duplication:
    """A share of the messages comes more than once."""

    begin_s: float
    duration_s: float
    share: float
    copies: int = 2


@dataclass(frozen=True)
class Reordering:
    """A share of the messages is held back and overtaken by those behind."""

    begin_s: float
    duration_s: float
    share: float
    held_s: float = 0.03


@dataclass(frozen=True)
class Freezing:
    """The sender repeats itself."""

    begin_s: float
    duration_s: float
    what: Frozen


@dataclass(frozen=True)
class Malformed:
    """A share of the messages is unusable."""

    begin_s: float
    duration_s: float
    how: Malformation
    share: float = 1.0


@dataclass(frozen=True)
class Silence:
    """The sender is silent; it returns with another identity, and its numbers begin again at 0."""

    begin_s: float
    duration_s: float


@dataclass(frozen=True)
class SecondSender:
    """Another sender reports a free way, on a clock that is ahead by `ahead_s`."""

    begin_s: float
    duration_s: float
    ahead_s: float


@dataclass(frozen=True)
class ClockStep:
    """The clock of the stamps steps by `step_s` (negative: back), and returns at the end."""

    begin_s: float
    duration_s: float
    step_s: float


Fault: TypeAlias = (
    Delay
    | Jitter
    | Loss
    | Duplication
    | Reordering
    | Freezing
    | Malformed
    | Silence
    | SecondSender
    | ClockStep
)

KINDS: Mapping[str, type[Any]] = arms_of(Fault)
"""Every kind by its name in a file: `delay`, `second-sender` and so on, in the order above."""


@dataclass(frozen=True)
class FaultScript:
    """Faults, and the seed of all random draws: equal scripts give equal faults.

    Raises:
        UsageError: a value is out of range.
    """

    faults: tuple[Fault, ...]
    seed: int = 0
    repeat_s: float = 0.0
    """Begin again after so long; 0: once."""

    def __post_init__(self) -> None:
        require(0 <= self.seed < 1 << 64, "seed", "0 to 2^64 − 1", self.seed)
        require(0.0 <= self.repeat_s < math.inf, "repeat_s", "0 or more", self.repeat_s)
        for number, fault in enumerate(self.faults):
            _check(fault, f"fault[{number}]")

    @property
    def end_s(self) -> float:
        """When the last fault ends; 0 without any."""
        return max((fault.begin_s + fault.duration_s for fault in self.faults), default=0.0)

    def active(self, time_s: float) -> tuple[Fault, ...]:
        """The faults that hold at a time, in the order of the script."""
        time_s = time_s % self.repeat_s if self.repeat_s else time_s
        return tuple(f for f in self.faults if f.begin_s <= time_s < f.begin_s + f.duration_s)


def kind_of(fault: Fault) -> str:
    """Name of a fault's kind."""
    return next(name for name, kind in KINDS.items() if isinstance(fault, kind))


def _check(fault: Fault, where: str) -> None:
    for name, value in dataclasses.asdict(fault).items():
        at = f"{where}.{name}"
        match name:
            case "begin_s" | "delay_s" | "jitter_s" | "held_s":
                require(0.0 <= value < math.inf, at, "0 or more seconds", value)
            case "duration_s":
                require(0.0 < value < math.inf, at, "more than 0 seconds", value)
            case "share":
                require(0.0 < value <= 1.0, at, "more than 0, at most 1", value)
            case "copies":
                require(2 <= value <= 100, at, "2 to 100", value)
            case "ahead_s" | "step_s":
                require(abs(value) <= 1e9, at, "at most 10^9 seconds either way", value)
