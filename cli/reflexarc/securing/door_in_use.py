"""The door of a robot in use, tried with what moves nothing and stops nothing.

That is: messages that cannot be decoded, on topics where such a message does not count. Whatever
comes on `stop` stops, so it is tried at a door of one's own alone. Silence proves something only
where somebody who has the right is heard, so those try it as well.
"""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from reflexarc.securing.door_row import DoorRow, DoorState, judged
from reflexarc.securing.gathering import guests_at
from reflexarc.securing.questions import ANSWER_S, answers_to, may_ask_for_a_swap
from reflexarc.securing.speaking import Heard, heard_of, named
from reflexarc.securing.variants import Settings, connecting, session
from reflexarc_runtime.messages.access import said_by
from reflexarc_runtime.messages.topics import (
    ARM,
    COMMAND,
    HOLD_TO_RUN,
    RECORDER_NODE,
    RELEASE,
    RESET,
)

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

GIBBERISH = b"\xff"
"""No protobuf: whoever hears it refuses it."""
HARMLESS = (COMMAND, ARM, RESET, HOLD_TO_RUN, RELEASE)
"""Topics on which a message counts only if it is in order."""


def rows_in_use(robot: str, settings: dict[str, Settings], locator: str) -> Iterator[DoorRow]:
    """Let every role that is here try what it may and what it may not.

    Raises:
        BusError: one does not come in.
    """
    with guests_at(locator, robot, settings) as guests:
        if RECORDER_NODE in settings:
            with session(robot, connecting(settings[RECORDER_NODE], locator)) as listener:
                heard = heard_of(listener, guests, HARMLESS, GIBBERISH)
            for role in guests:
                yield from _speaking_rows(role, heard)
        else:
            words = "recorder.json5, which listens, is not here"
            yield DoorRow("who moves the robot", DoorState.UNTRIED, words)
        yield _swap_row(robot, guests)


def _speaking_rows(role: str, heard: Heard) -> Iterator[DoorRow]:
    tried = {topic.name for topic in HARMLESS}
    did, may = heard.names_of(role), {topic.name for topic in said_by(role)} & tried
    proved = {name for _, name in heard.said}
    opened = [f"was heard on {named(did - may)}"] if did - may else []
    lacking = [f"was not heard on {named(may - did)}"] if may - did else []
    silent = (tried & proved) - may
    words = [f"heard on {named(may)}"] * bool(may) + [f"silent on {named(silent)}"] * bool(silent)
    door = f"{role} at the robot in use"
    if words or opened:
        yield judged(door, opened, lacking, "; ".join(words))
    unproved = tried - proved - may
    if unproved:
        nothing = f"nobody is heard on {named(unproved)}: that {role} is not proves nothing"
        yield DoorRow(door, DoorState.UNTRIED, nothing)


def _swap_row(robot: str, guests: "dict[str, Bus]") -> DoorRow:
    """Everybody asks for another policy, in words that no runtime can read.

    Who is heard shows in the answer alone, here; at a door of one's own, in the request as well.
    """
    door = "who asks for another policy"
    answered = {role for role, found in answers_to(guests, _answers).items() if found}
    may = {role for role in guests if may_ask_for_a_swap(role, robot)}
    opened = [f"{role} is answered" for role in sorted(answered - may)]
    if opened or answered:
        lacking = [f"{role} is not answered" for role in sorted(may - answered)]
        return judged(door, opened, lacking, f"{named(may)} alone is answered")
    return DoorRow(door, DoorState.UNTRIED, "a runtime answers nobody here: does one run?")


def _answers(_: str, bus: "Bus") -> set[str]:
    return {"answered"} if bus.request_swap(GIBBERISH, ANSWER_S) else set()
