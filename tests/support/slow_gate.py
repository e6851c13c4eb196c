"""The rules of a body's gate once more, told from the whole of what it heard, slowly.

Nothing is carried from one message to the next: whoever asks anything gets it from the list of all
events, read from its beginning.
"""

import math
from collections import Counter
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

SPEEDS = tuple[float, float, float]
STILL = (0.0, 0.0, 0.0)


Kind = Literal[
    "drive", "safe", "stop", "reset", "arm", "release", "give back", "hold", "let go", "look"
]


@dataclass(frozen=True)
class Event:
    """One thing that was heard, or a look at what the body does."""

    kind: Kind
    at_ms: int
    sender: str = "a"
    """`?`: it gave none."""
    source_ms: int = 0
    valid_for_ms: int = 100
    speeds: SPEEDS = (1.0, 0.0, 0.0)
    is_for_us: bool = True
    is_in_order: bool = True
    """Whether its encoding is what it should be."""
    pressed_ms: int = 0
    """When the button went down, of a hold."""


@dataclass(frozen=True)
class ButtonAtEvent:
    """Who holds the button when an event comes and after it, and why it changed nothing."""

    before: str | None
    after: str | None
    refused: str = ""


@dataclass(frozen=True)
class SlowGate:
    """All that was heard by a body, oldest first."""

    events: tuple[Event, ...]
    silence_ms: int
    valid_for_ms: int
    largest: SPEEDS
    auto_arm: bool
    hold_to_run: bool = False

    def holders(self) -> list[tuple[str | None, int]]:
        """(holder, number of grants) after each event."""
        holder: str | None = None
        waiting: str | None = None
        grants = spoke_ms = freed_ms = 0
        found = []
        for event in self.events:
            if holder is not None and event.at_ms > spoke_ms + self.silence_ms:
                holder = None
            if waiting is not None and event.at_ms > freed_ms + self.silence_ms:
                waiting = None
            is_release = event.kind == "release" or (
                event.kind == "give back" and event.sender == holder
            )
            if is_release and self.counts(event) and holder is not None:
                holder, waiting, freed_ms = None, holder, event.at_ms
            if event.kind in ("drive", "safe") and self.counts(event):
                if holder is None and event.sender != waiting:
                    holder, waiting, grants = event.sender, None, grants + 1
                if holder == event.sender:
                    spoke_ms = event.at_ms
            found.append((holder, grants))
        return found

    @cached_property
    def buttons(self) -> list[ButtonAtEvent]:
        """The button at each event."""
        found = list[ButtonAtEvent]()
        freed_ms, heard_ms = 0, 0
        for index, event in enumerate(self.events):
            holder = found[-1].after if found else None
            if holder is not None and event.at_ms - heard_ms >= 500:
                holder, freed_ms = None, event.at_ms
            after, refused = holder, ""
            if event.kind == "stop" or (event.kind == "reset" and self.counts(event)):
                after, freed_ms = None, event.at_ms
            if event.kind in ("hold", "let go"):
                refused = self._fault_of_grip(index, holder, freed_ms)
                after = holder if refused else event.sender if event.kind == "hold" else None
            if event.kind == "let go" and holder is not None and after is None:
                freed_ms = event.at_ms
            if event.kind == "hold" and not refused:
                heard_ms = event.source_ms if holder is None else max(heard_ms, event.source_ms)
            found.append(ButtonAtEvent(holder, after, refused))
        return found

    def _fault_of_grip(self, index: int, holder: str | None, freed_ms: int) -> str:
        event = self.events[index]
        is_hold = event.kind == "hold"
        if not (event.is_in_order and event.sender != "?" and event.is_for_us):
            return "faulty"
        if is_hold and self.stopped(index):
            return "stopped"
        if holder not in (None, event.sender):
            return "button"
        if not is_hold:
            return ""
        if event.pressed_ms > event.at_ms or not 0 <= event.at_ms - event.source_ms < 500:
            return "faulty"
        return "button" if event.pressed_ms < freed_ms else ""

    def counts(self, event: Event) -> bool:
        """Whether an event is in order by itself, whoever sent it."""
        if event.kind in ("stop", "look"):
            return True
        if not event.is_in_order or event.sender == "?":
            return False
        if event.kind == "drive":
            fits = event.is_for_us and all(map(math.isfinite, event.speeds))
            return fits and self.holds(event, event.at_ms)
        return True

    def holds(self, event: Event, at_ms: int) -> bool:
        """Whether a drive command is still valid."""
        age_ms = at_ms - event.source_ms
        return 0 <= age_ms < min(event.valid_for_ms, self.valid_for_ms)

    def stopped(self, until: int) -> bool:
        """Whether a stop came after the last reset, within the first `until` events."""
        kinds = [e.kind for e in self.events[:until] if self.counts(e)]
        marks = [kind for kind in kinds if kind in ("stop", "reset")]
        return bool(marks) and marks[-1] == "stop"

    def armed(self, until: int) -> bool:
        """Whether it is armed after the first `until` events."""
        return self.allowed(until) or (until > 0 and self.buttons[until - 1].after is not None)

    def armed_before(self, index: int) -> bool:
        """Whether it is armed when an event comes, and no button is too old at that time."""
        return self.allowed(index) or self.buttons[index].before is not None

    def allowed(self, until: int) -> bool:
        """Whether an arm that counted came after the last reset, or none is needed."""
        if self.auto_arm or self.hold_to_run:
            return self.auto_arm
        for index in reversed(range(until)):
            event = self.events[index]
            if event.kind == "reset" and self.counts(event):
                return False
            if event.kind == "arm" and self.counts(event) and not self.stopped(index):
                return True
        return False

    def does(self) -> SPEEDS:
        """What the body does at the last event, a look."""
        last, holders = self.events[-1], self.holders()
        if self.stopped(len(self.events)) or not self.armed(len(self.events)):
            return STILL
        for index in reversed(range(len(self.events))):
            event = self.events[index]
            if event.kind in ("stop", "look") or not self.counts(event):
                if event.kind == "stop":
                    return STILL
                continue
            if event.kind == "arm":
                if self.hold_to_run or self.stopped(index) or self.armed_before(index):
                    continue
                return STILL
            if event.kind in ("hold", "let go"):
                if self.armed_before(index) == self.armed(index + 1):
                    continue
                return STILL
            if event.kind in ("reset", "release"):
                return STILL
            if event.kind == "give back":
                if index and holders[index - 1][0] == event.sender and not holders[index][0]:
                    return STILL
                continue
            if event.sender != holders[index][0]:
                continue
            is_mine = holders[-1] == holders[index] and event.kind == "drive"
            return self.slowed(event.speeds) if is_mine and self.holds(event, last.at_ms) else STILL
        return STILL

    def slowed(self, speeds: SPEEDS) -> SPEEDS:
        """Speeds in the same direction that exceed no limit."""
        shares = [most / abs(v) for v, most in zip(speeds, self.largest, strict=True) if v]
        share = min([1.0, *shares])
        linear, lateral, angular = speeds
        return linear * share, lateral * share, angular * share

    def refused(self) -> Counter[str]:
        """How many of the commands did not reach the motor as they were, by kind of reason."""
        counts: Counter[str] = Counter()
        holders = self.holders()
        for index, event in enumerate(self.events):
            if event.kind not in ("drive", "safe"):
                continue
            if not self.counts(event):
                counts["faulty"] += 1
            elif holders[index][0] != event.sender:
                counts["not the holder"] += 1
            elif event.kind == "drive" and self.stopped(index):
                counts["stopped"] += 1
            elif event.kind == "drive" and not self.armed_before(index):
                counts["disarmed"] += 1
        counts.update(button.refused for button in self.buttons if button.refused)
        return counts
