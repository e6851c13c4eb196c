"""Whether everybody at a door hears its robot, and nobody anything else."""

import time
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from reflexarc.securing.door_row import DoorRow, judged
from reflexarc.securing.gathering import ARRIVES_WITHIN_S, NOBODY, SETTLES_S, Gathering
from reflexarc.securing.speaking import named
from reflexarc_runtime.messages.access import CARRIED
from reflexarc_runtime.messages.topics import STATUS
from reflexarc_runtime.messages.wire import Message, UndecodableError, unpack_stamp

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Publisher

ANOTHER = "another"
"""A robot that is not the door's."""
_EVERYTHING = "**"
_FOREIGN = (STATUS.key(ANOTHER), f"{ANOTHER}/secret")


@dataclass
class _Ears:
    """What each hears of the door's own session."""

    host: bytes
    heard: dict[str, set[str]] = field(default_factory=dict)
    """Role → keys."""

    def hear(self, role: str, message: Message) -> None:
        """Called on threads of the bus."""
        try:
            if unpack_stamp(message.attachment).sender == self.host:
                self.heard[role].add(message.key)
        except UndecodableError:
            return


def hearing_row(all_here: Gathering) -> DoorRow:
    """The door says everything, of its robot and of another one; each listens to each key."""
    own = {topic.key(all_here.robot) for topic in CARRIED}
    ears = _Ears(all_here.host.sender, {role: set() for role in all_here.guests})
    for role, bus in all_here.guests.items():
        for key in (*sorted(own), *_FOREIGN, _EVERYTHING):
            bus.subscribe_to_key(key, partial(ears.hear, role))
    time.sleep(SETTLES_S)
    publishers = [all_here.host.publisher_of_key(key, "", STATUS.quality) for key in own]
    publishers += [all_here.host.publisher_of_key(key, "", STATUS.quality) for key in _FOREIGN]
    _say_until(publishers, ears, all_here.roles, own)
    return _judged(all_here, ears, own)


def _say_until(publishers: "list[Publisher]", ears: _Ears, roles: list[str], own: set[str]) -> None:
    end_s = time.monotonic() + ARRIVES_WITHIN_S
    while time.monotonic() < end_s:
        for publisher in publishers:
            publisher.put(b"", 0)
        time.sleep(SETTLES_S)
        if all(own <= ears.heard[role] for role in roles):
            return


def _judged(all_here: Gathering, ears: _Ears, own: set[str]) -> DoorRow:
    opened = [
        f"{role} hears of another robot" for role in all_here.guests if ears.heard[role] - own
    ]
    if ears.heard.get(NOBODY, set()) & own:
        opened.append(f"{NOBODY}, a certificate of no role, hears")
    deaf = {role: own - ears.heard[role] for role in all_here.roles}
    lacking = [
        f"{role} does not hear {named(key.partition('/')[2] for key in keys)}"
        for role, keys in deaf.items()
        if keys
    ]
    words = f"each role hears the {len(own)} topics of its robot; what is of another one, none"
    words += "; no role, no hearing" if NOBODY in all_here.guests else ""
    return judged("who hears", opened, lacking, words)
