"""One door, and whether it is shut."""

from collections.abc import Iterable
from dataclasses import dataclass
from enum import StrEnum


class DoorState(StrEnum):
    """What was found at a door."""

    SHUT = "shut"
    """Who shall not come in gets nowhere; who shall, does."""
    OPEN = "OPEN"
    """Somebody gets in who shall not."""
    BROKEN = "broken"
    """Somebody does not get in who shall: nothing else is proved by silence then."""
    UNTRIED = "not tried"


@dataclass(frozen=True)
class DoorRow:
    """What was tried at one door, and how it went."""

    door: str
    state: DoorState
    words: str

    @property
    def is_bad(self) -> bool:
        """Whether something is to be done."""
        return self.state in (DoorState.OPEN, DoorState.BROKEN)


def row(door: str, found: Iterable[str], otherwise: str) -> DoorRow:
    """Open if anything was found.

    Args:
        door: its name.
        found: what is wrong, in words.
        otherwise: what is said of it if nothing is.
    """
    wrong = list(found)
    return DoorRow(door, DoorState.OPEN if wrong else DoorState.SHUT, "; ".join(wrong) or otherwise)
