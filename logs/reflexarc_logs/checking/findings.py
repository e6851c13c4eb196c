"""What is amiss in a log, in words, and how bad it is.

An error means that the log is not, or does not say, what happened: bytes that do not fit their CRC,
records that are missing, a clock that went back, a replay that differs. A warning means that the
log is true and something in it should be looked at: a silence, a skipped tick, a sender's clock
that drifts, a policy that nothing seals.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal, TypeAlias

Severity: TypeAlias = Literal["error", "warning"]
FindingKind: TypeAlias = Literal["bytes", "completeness", "gaps", "clocks", "contract", "replay"]

_SHOWN = 3


@dataclass(frozen=True, slots=True)
class LogFinding:
    """One thing that is amiss."""

    kind: FindingKind
    severity: Severity
    words: str


def error(kind: FindingKind, words: str) -> LogFinding:
    """A finding that makes a log untrue."""
    return LogFinding(kind, "error", words)


def warning(kind: FindingKind, words: str) -> LogFinding:
    """A finding in a log that is true."""
    return LogFinding(kind, "warning", words)


def few(words: Iterable[str]) -> str:
    """The first of some words, and how many more there are."""
    said = list(words)
    more = len(said) - _SHOWN
    return ", ".join(said[:_SHOWN]) + (f" and {more} more" if more > 0 else "")


def time_words(time_ns: float) -> str:
    """A length of time, for people."""
    size = abs(time_ns)
    if size < 1e6:
        return f"{time_ns * 1e-3:.0f} µs"
    return f"{time_ns * 1e-6:.1f} ms" if size < 1e9 else f"{time_ns * 1e-9:.2f} s"
