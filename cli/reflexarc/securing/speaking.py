"""Whether everybody at a door says what it may, and nothing else: tried with real sessions.

Every role, and a certificate of no role, speaks on every topic; a listener at the door compares
who was heard with the topic table.
"""

import time
from collections.abc import Iterable, Iterator
from contextlib import AbstractContextManager, ExitStack
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from reflexarc.securing.authority import Authority, Validity
from reflexarc.securing.door_row import DoorRow, DoorState
from reflexarc.securing.secured_robot import SecuredRobot
from reflexarc.securing.variants import Settings, connecting, listening, session, showing
from reflexarc_runtime.messages.access import CARRIED, common_name, said_by
from reflexarc_runtime.messages.topics import RUNTIME_NODE, Topic, alive_key
from reflexarc_runtime.messages.wire import Message, UndecodableError, unpack_stamp

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus

ARRIVES_WITHIN_S = 5.0
SETTLES_S = 0.3
"""How long is waited for what shall not come, once all has come that shall."""
NOBODY = "nobody"
"""A certificate of the right authority that names no role."""
_SECRET = "another/secret"


@dataclass
class _Heard:
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


@dataclass(frozen=True)
class DoorUnderTrial:
    """A door of one's own, with the rights of the folder's, at a free port."""

    secured: SecuredRobot
    door: Settings
    """Its settings."""
    guests: dict[str, Settings]
    """Role → settings."""
    port: int

    def rows(self, authority: Authority | None) -> Iterator[DoorRow]:
        """Let everybody speak."""
        guests = dict(self.guests)
        if authority is not None and guests:
            named = authority.issue(common_name(NOBODY, self.secured.robot), Validity.of_days(1))
            guests[NOBODY] = showing(next(iter(guests.values())), named)
        heard = _Heard()
        with ExitStack() as stack:
            settings = listening(self.door, self.port)
            host = stack.enter_context(session(self.secured.robot, settings))
            host.subscribe(CARRIED, heard.hear)
            buses = {role: stack.enter_context(self._guest(guests[role])) for role in guests}
            heard.senders.update({bus.sender: role for role, bus in buses.items()})
            _speak(buses, heard)
            for role in guests:
                yield _row_of(role, heard)
            yield _elsewhere(host, buses)
            yield _impostors(host, buses, self.secured.robot)

    def _guest(self, settings: Settings) -> AbstractContextManager["Bus"]:
        return session(self.secured.robot, connecting(settings, f"tls/127.0.0.1:{self.port}"))


def _speak(buses: "dict[str, Bus]", heard: _Heard) -> None:
    """Everybody says everything, until all is heard that may be."""
    wanted = {(role, topic.name) for role in buses for topic in said_by(role)}
    publishers = [bus.publisher(topic) for bus in buses.values() for topic in CARRIED]
    end_s = time.monotonic() + ARRIVES_WITHIN_S
    while time.monotonic() < end_s:
        for publisher in publishers:
            publisher.put(b"", time.monotonic_ns())
        time.sleep(SETTLES_S)
        if wanted <= heard.said:
            return


def _row_of(role: str, heard: _Heard) -> DoorRow:
    may = {topic.name for topic in said_by(role)}
    did = {name for who, name in heard.said if who == role}
    door = f"{role} says what it may" if may else f"{role} says nothing"
    if did - may:
        return DoorRow(door, DoorState.OPEN, f"was heard on {_named(did - may)}")
    if may - did:
        return DoorRow(door, DoorState.BROKEN, f"was not heard on {_named(may - did)}")
    silent = f"silent on the {len(CARRIED) - len(may)} others"
    words = f"heard on {_named(may)}; {silent}" if may else f"silent on all {len(CARRIED)} topics"
    return DoorRow(door, DoorState.SHUT, words)


def _named(names: Iterable[str]) -> str:
    return ", ".join(sorted(names))


def _elsewhere(host: "Bus", buses: "dict[str, Bus]") -> DoorRow:
    """What is of no robot, or of another one, is heard by nobody; nobody without a role hears."""
    heard: set[str] = set()
    for role, bus in buses.items():
        for key in ("**", _SECRET):
            bus.subscribe_to_key(key, partial(_note, heard, role))
    time.sleep(SETTLES_S)
    known = Topic("status", CARRIED[0].message, (), "")
    secret = host.publisher_of_key(_SECRET, "", known.quality)
    own = host.publisher(known)
    for _ in range(3):
        secret.put(b"", 0)
        own.put(b"", 0)
        time.sleep(SETTLES_S)
    wrong = [f"{role} hears of another robot" for role in heard & set(buses)]
    wrong += [f"{role} hears" for role in heard if role == f"{NOBODY} own"]
    words = "what is of another robot is heard by none; no role, no hearing"
    return DoorRow(
        "who hears", DoorState.OPEN if wrong else DoorState.SHUT, "; ".join(wrong) or words
    )


def _note(heard: set[str], role: str, message: Message) -> None:
    heard.add(role if message.key == _SECRET else f"{role} own")


def _impostors(host: "Bus", buses: "dict[str, Bus]", robot: str) -> DoorRow:
    """Who else answers for the policy, or says that a runtime lives."""
    others = {role: bus for role, bus in buses.items() if role != RUNTIME_NODE}
    for role, bus in others.items():
        bus.offer_policy(partial(str.encode, role))
        bus.announce(RUNTIME_NODE)
    time.sleep(SETTLES_S)
    wrong = [
        f"{answer.data.decode()} answers for the policy" for answer in host.policy_answers(1.0)
    ]
    if alive_key(robot, RUNTIME_NODE) in host.tokens("*/alive/*"):
        wrong.append("others pass for a runtime that lives")
    words = "nobody but a runtime answers for the policy, or passes for one"
    return DoorRow(
        "impostors", DoorState.OPEN if wrong else DoorState.SHUT, "; ".join(wrong) or words
    )
