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


def judged(door: str, opened: list[str], lacking: list[str], otherwise: str) -> DoorRow:
    """Open if somebody may what it shall not; else broken if somebody may not what it shall.

    Args:
        door: its name.
        opened: what is done that nobody shall, in words.
        lacking: what is not done that somebody shall; silence proves nothing of it then.
        otherwise: what is said if there is nothing of either.
    """
    state = DoorState.OPEN if opened else DoorState.BROKEN if lacking else DoorState.SHUT
    return DoorRow(door, state, "; ".join((*opened, *lacking)) or otherwise)


def row(door: str, found: Iterable[str], otherwise: str) -> DoorRow:
    """Open if anything was found.

    Args:
        door: its name.
        found: what is wrong, in words.
        otherwise: what is said of it if nothing is.
    """
    wrong = list(found)
    return DoorRow(door, DoorState.OPEN if wrong else DoorState.SHUT, "; ".join(wrong) or otherwise)
