"""Who at a door may ask for what, and who answers: the policy, and another policy.

Whoever may ask for another policy chooses who drives: the strongest right of all.
"""

import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import TYPE_CHECKING

from reflexarc.securing.door_row import DoorRow, judged
from reflexarc.securing.gathering import NOBODY, SETTLES_S, Gathering
from reflexarc_runtime.messages.access import asked_keys
from reflexarc_runtime.messages.topics import RUNTIME_NODE, swap_key

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

ANSWER_S = 1.0
_DOOR = "door"


def asking_row(all_here: Gathering) -> DoorRow:
    """Everybody asks for the policy and for another one; the door itself answers."""
    asked: set[str] = set()
    _answer_as(_DOOR, all_here.host, asked)
    time.sleep(SETTLES_S)
    learned = answers_to(all_here.guests, _policies)
    swapped = answers_to(all_here.guests, _swaps)
    roles = all_here.roles
    may_swap = {role for role in roles if may_ask_for_a_swap(role, all_here.robot)}
    opened = [f"{role} asks for another policy" for role in sorted(asked - may_swap)]
    opened += [f"{NOBODY} learns the policy"] * bool(learned.get(NOBODY))
    lacking = [f"{role} cannot ask for another policy" for role in sorted(may_swap - asked)]
    lacking += [f"{role} is not answered" for role in sorted(may_swap & asked) if not swapped[role]]
    lacking += [f"{role} does not learn the policy" for role in roles if not learned[role]]
    who = ", ".join(sorted(may_swap)) or "nobody here"
    words = f"{who} alone asks for another policy; each role learns which one drives"
    return judged("who asks", opened, lacking, words)


def answering_row(all_here: Gathering) -> DoorRow:
    """Everybody answers for the policy, and takes requests for another one; the door asks."""
    for role, bus in all_here.guests.items():
        _answer_as(role, bus, set())
    time.sleep(SETTLES_S)
    told = {
        "answers for the policy": _policies(_DOOR, all_here.host),
        "takes requests for another policy": _swaps(_DOOR, all_here.host),
    }
    opened = [
        f"{role} {does}"
        for does, found in told.items()
        for role in sorted(found - {RUNTIME_NODE, _DOOR})
    ]
    is_here = RUNTIME_NODE in all_here.guests
    lacking = [
        f"{RUNTIME_NODE} is not heard when it {does}"
        for does, found in told.items()
        if is_here and RUNTIME_NODE not in found
    ]
    return judged("who answers", opened, lacking, "the runtime alone answers those who ask")


def may_ask_for_a_swap(role: str, robot: str) -> bool:
    """Whether the rights are so."""
    return swap_key(robot) in asked_keys(role, robot)


def answers_to(
    buses: "dict[str, Bus]", ask: "Callable[[str, Bus], set[str]]"
) -> dict[str, set[str]]:
    """Who answered whom; all ask at once, as whoever may not waits for the whole time."""
    with ThreadPoolExecutor(len(buses)) as pool:
        return dict(zip(buses, pool.map(ask, buses, buses.values()), strict=True))


def _answer_as(name: str, bus: "Bus", asked: set[str]) -> None:
    """Answer both questions with a name, and note whose requests came."""

    def deal(request: bytes, answer: Callable[[bytes], None]) -> None:
        asked.add(request.decode(errors="replace"))
        answer(name.encode())

    bus.offer_policy(partial(str.encode, name))
    bus.take_requests(deal)


def _policies(_: str, bus: "Bus") -> set[str]:
    return {answer.data.decode(errors="replace") for answer in bus.policy_answers(ANSWER_S)}


def _swaps(role: str, bus: "Bus") -> set[str]:
    return {said.decode(errors="replace") for said in bus.request_swap(role.encode(), ANSWER_S)}
