"""What an attack did, as a row of a table."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum


class Held(StrEnum):
    """Whether the defence held."""

    YES = "yes"
    NO = "**NO**"
    KNOWN = "no, as said"
    """It gets through, and the documentation says so: there is no authentication."""


@dataclass(frozen=True)
class Outcome:
    """One row."""

    attack: str
    tried: str
    """What was done, with numbers."""
    distance_m: float | None
    """How far the robot rolled because of it; None: nothing here can roll."""
    said: str
    """What body and runtime said about it."""
    held: Held


def held_if(holds: bool) -> Held:
    """Yes or no."""
    return Held.YES if holds else Held.NO


def known_if(gets_through: bool) -> Held:
    """For an attack that is known to get through: not held, as the documentation says; or held."""
    return Held.KNOWN if gets_through else Held.YES


def table(outcomes: Iterable[Outcome]) -> str:
    """All rows, in Markdown."""
    head = ["attack", "what was tried", "rolled by it, m", "what was said", "held?"]
    lines = ["| " + " | ".join(head) + " |", "|---|---|---|---|---|"]
    return "\n".join([*lines, *map(row, outcomes)])


def row(outcome: Outcome) -> str:
    """One row, in Markdown."""
    distance = "–" if outcome.distance_m is None else f"{outcome.distance_m:.2f}"
    cells = [outcome.attack, outcome.tried, distance, outcome.said, outcome.held.value]
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"


def counts(now: Mapping[str, int], before: Mapping[str, int] | None = None) -> str:
    """What was counted since, by reason."""
    since = {name: n - (before or {}).get(name, 0) for name, n in now.items()}
    return ", ".join(f"{n} × {name}" for name, n in since.items() if n) or "nothing refused"


def last_line(text: str) -> str:
    """The last line of what a process said, quoted and of a length that fits a table."""
    lines = text.strip().splitlines() or [""]
    words = re.sub(r"/\S*/", "", lines[-1])  # the folders are this run's own
    return f"`{words[:160]}`"
