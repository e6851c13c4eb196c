"""Whether everybody at a door says what it may, and nothing else.

Everybody speaks on every topic, and a listener compares who was heard with the topic table.
"""

import time
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from reflexarc.securing.door_row import DoorRow, DoorState
from reflexarc.securing.gathering import ARRIVES_WITHIN_S, SETTLES_S, Gathering
from reflexarc_runtime.messages.access import CARRIED, said_by
from reflexarc_runtime.messages.topics import Topic
from reflexarc_runtime.messages.wire import Message, UndecodableError, unpack_stamp

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus


@dataclass
class Heard:
    """Who was heard on which topic."""

    senders: dict[bytes, str] = field(default_factory=dict)
    """Identifier → role."""
    said: set[tuple[str, str]] = field(default_factory=set)
    """Role and topic."""

    def hear(self, message: Message) -> None:
        """Called on a thread of the bus."""
        try:
            sender = unpack_stamp(message.attachment).sender
        except UndecodableError:
            return
        if sender in self.senders:
            self.said.add((self.senders[sender], message.key.rpartition("/")[2]))

    def names_of(self, role: str) -> set[str]:
        """The topics on which a role was heard."""
        return {name for who, name in self.said if who == role}


def heard_of(
    listener: "Bus", speakers: "dict[str, Bus]", topics: Sequence[Topic], payload: bytes
) -> Heard:
    """Let everybody say everything, until all is heard that may be.

    What it may say each says as it does in a drive, by a publisher. All else is sent unasked.
    """
    heard = Heard({bus.sender: role for role, bus in speakers.items()})
    listener.subscribe(topics, heard.hear)
    wanted = {(role, topic.name) for role in speakers for topic in said_by(role) if topic in topics}
    pairs = [(role, topic) for role in speakers for topic in topics]
    publishers = [speakers[r].publisher(topic) for r, topic in pairs if topic in said_by(r)]
    unasked = [(speakers[r], topic) for r, topic in pairs if topic not in said_by(r)]
    end_s = time.monotonic() + ARRIVES_WITHIN_S
    while time.monotonic() < end_s:
        for publisher in publishers:
            publisher.put(payload, time.monotonic_ns())
        for bus, topic in unasked:
            bus.send_unasked(topic, payload, time.monotonic_ns())
        time.sleep(SETTLES_S)
        if wanted <= heard.said:
            break
    return heard


def speaking_rows(all_here: Gathering) -> Iterator[DoorRow]:
    """What each says."""
    heard = heard_of(all_here.host, all_here.guests, CARRIED, b"")
    for role in all_here.guests:
        yield _row_of(role, heard.names_of(role))


def _row_of(role: str, did: set[str]) -> DoorRow:
    may = {topic.name for topic in said_by(role)}
    door = f"{role} says what it may" if may else f"{role} says nothing"
    if did - may:
        return DoorRow(door, DoorState.OPEN, f"was heard on {named(did - may)}")
    if may - did:
        return DoorRow(door, DoorState.BROKEN, f"was not heard on {named(may - did)}")
    silent = f"silent on the {len(CARRIED) - len(may)} others"
    words = f"heard on {named(may)}; {silent}" if may else f"silent on all {len(CARRIED)} topics"
    return DoorRow(door, DoorState.SHUT, words)


def named(names: Iterable[str]) -> str:
    """Some of them, in one line."""
    return ", ".join(sorted(names))
