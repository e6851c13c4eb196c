"""One thing that was looked at on a machine: what was found, whether it is well, what to do."""

from dataclasses import dataclass
from enum import StrEnum


class Health(StrEnum):
    """Whether it is well."""

    WELL = "well"
    MIND = "mind"
    """It costs something, or may; a robot can drive with it."""
    BAD = "BAD"
    """The contract's rate, or safety, cannot be had with it."""
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class CheckRow:
    """What was found, and what follows."""

    name: str
    health: Health
    found: str
    why: str = ""
    """Why that matters; empty where it is well."""
    remedy: str = ""


def well(name: str, found: str) -> CheckRow:
    """There is nothing to do."""
    return CheckRow(name, Health.WELL, found)


def unknown(name: str, why: str) -> CheckRow:
    """It could not be found out."""
    return CheckRow(name, Health.UNKNOWN, "could not be found out", why)
