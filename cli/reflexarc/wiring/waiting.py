"""Whoever waits says for what, on which key, and what it hears instead."""

import threading
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import TracebackType
from typing import TYPE_CHECKING, Self

from reflexarc.terminal.output import aside

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.messages.wire import Message

PATIENCE_S = 3.0
LISTEN_S = 1.0
AGAIN_S = 10.0
_MOST_NAMED = 4
_LONGEST_KEY = 80
ANOTHER_ROBOT = {"": "another robot, --robot {first}?"}
"""What to do where only others are heard."""


@dataclass(frozen=True)
class Wish:
    """What a command waits for."""

    who: str
    """The command, for the line."""
    what: str
    """In words: retinas, a runtime."""
    key: str
    """The key on which it should come; empty if it is no message."""
    around: tuple[str, ...] = ("*/*",)
    """Key expressions of what it might be instead."""
    advice: Mapping[str, str] = field(default_factory=lambda: ANOTHER_ROBOT)
    """For keys that end so: what to do about it. `{first}` stands for the key's first part."""
    tokens: str = "*/alive/*"
    """And of nodes that say that they are there."""


class Arrival:
    """Passes messages on, and knows whether one has come.

    Args:
        deliver: takes them.
    """

    def __init__(self, deliver: Callable[["Message"], None]) -> None:
        self._deliver = deliver
        self._came = False

    def hear(self, message: "Message") -> None:
        """Take one message; called on a thread of the bus."""
        self._came = True
        self._deliver(message)

    def __call__(self) -> bool:
        """Whether one has come."""
        return self._came


@dataclass(frozen=True)
class Surroundings:
    """What there is on the bus beside what is waited for."""

    heard: Mapping[str, int]
    """How often each key was heard in a second."""
    tokens: Sequence[str]
    """Which nodes say that they are there."""
    neighbours: int
    """Routers and peers that are connected."""
    loneliness: str = "nobody is connected"
    """What it means that there are none."""

    @property
    def things(self) -> set[str]:
        """All that could be told of them."""
        return {*self.heard, *self.tokens, "" if self.neighbours else self.loneliness}


class Waiting:
    """Explains a silence of more than three seconds; a context manager around the waiting.

    It speaks again only when there is something that it has not told of.

    Args:
        bus: where to listen.
        wish: what is waited for.
        has_come: whether it came.
    """

    def __init__(self, bus: "Bus", wish: Wish, has_come: Callable[[], bool]) -> None:
        self._bus, self._wish, self._has_come = bus, wish, has_come
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._watch, name="waiting", daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._ended.set()
        self._thread.join(2.0 * LISTEN_S)

    def _watch(self) -> None:
        told: set[str] = set()
        patience_s = PATIENCE_S
        while not self._ended.wait(patience_s) and not self._has_come():
            around = look_around(self._bus, self._wish, lambda: self._ended.wait(LISTEN_S))
            if self._has_come() or self._ended.is_set():
                return
            if not around.things <= told:
                aside.print(explained(self._wish, around), soft_wrap=True)
            told, patience_s = told | around.things, AGAIN_S


def look_around(bus: "Bus", wish: Wish, wait: Callable[[], object]) -> Surroundings:
    """Listen for as long as `wait` takes, a second as a rule."""
    heard = bus.overhear(wish.around, wait)
    return Surroundings(heard, bus.tokens(wish.tokens), bus.neighbours, bus.loneliness)


def explained(wish: Wish, around: Surroundings) -> str:
    """What is waited for, and why it is silent, in a line."""
    waits = f"{wish.who}: waits for {wish.what}" + f" on {wish.key}" * bool(wish.key)
    return f"{waits}; {reason(wish, around)}"


def reason(wish: Wish, around: Surroundings) -> str:
    """Why it is silent, in words."""
    if not around.neighbours:
        return around.loneliness
    others = {key: count for key, count in around.heard.items() if key != wish.key}
    if not others:
        named = ", ".join(map(_shortened, sorted(around.tokens)[:_MOST_NAMED]))
        there = f", of which {named}" * bool(named)
        return f"{around.neighbours} connected{there}: none sends it"
    most = sorted(others, key=lambda key: (not _advice(wish, key), -others[key], key))
    most = most[:_MOST_NAMED]
    named = ", ".join(f"{_shortened(key)} ({others[key]} a second)" for key in most)
    return f"hears {named} instead{_advice(wish, most[0])}"


def _advice(wish: Wish, key: str) -> str:
    """What to do about a key; an ending without a robot is about other robots alone."""
    robot, _, _ = wish.key.partition("/")
    first, _, _ = key.partition("/")
    for ending, words in wish.advice.items():
        is_of_others = not ending or ending.startswith("/")
        if key.endswith(ending) and not (is_of_others and first == robot):
            return ": " + words.format(first=_shortened(first), key=_shortened(key))
    return ""


def _shortened(key: str) -> str:
    """A stranger's key, on one line that a terminal bears."""
    return "".join(c if c.isprintable() else "?" for c in key)[:_LONGEST_KEY]
