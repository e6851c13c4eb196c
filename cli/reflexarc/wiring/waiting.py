"""Whoever waits says for what, on which key, and what it hears instead."""

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import TracebackType
from typing import TYPE_CHECKING, Self

from reflexarc.terminal.output import aside, plain

if TYPE_CHECKING:
    from reflexarc_runtime.bus import Bus
    from reflexarc_runtime.messages.wire import Message

PATIENCE_S = 3.0
LISTEN_S = 1.0
AGAIN_S = 10.0
_MOST_NAMED = 4


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
    advice: Mapping[str, str] | None = None
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


class Waiting:
    """Explains a silence of more than three seconds; a context manager around the waiting.

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
        said, patience_s = "", PATIENCE_S
        while not self._ended.wait(patience_s) and not self._has_come():
            words = explain(self._bus, self._wish, self._ended.wait)
            if self._has_come() or self._ended.is_set():
                return
            if words != said:
                aside.print(plain(words), soft_wrap=True)
            said, patience_s = words, AGAIN_S


def explain(bus: "Bus", wish: Wish, wait: Callable[[float], object] = time.sleep) -> str:
    """Listen for a second, and say why it is silent."""
    heard = bus.overhear(wish.around, LISTEN_S, wait)
    return explained(wish, heard, bus.tokens(wish.tokens), bus.neighbours, bus.place)


def explained(
    wish: Wish, heard: Mapping[str, int], tokens: Sequence[str], neighbours: int, place: str
) -> str:
    """Why it is silent, in a line.

    Args:
        wish: what is waited for.
        heard: how often each key was heard instead, in a second.
        tokens: which nodes say that they are there.
        neighbours: routers and peers that are connected.
        place: where the bus is looked for.
    """
    waits = f"{wish.who}: waits for {wish.what}" + f" on {wish.key}" * bool(wish.key)
    if not neighbours:
        return f"{waits}; nobody answers at {place} (is it started? another --port?)"
    others = {key: count for key, count in heard.items() if key != wish.key}
    if not others:
        there = f", of which {', '.join(sorted(tokens)[:_MOST_NAMED])}" * bool(tokens)
        return f"{waits}; {neighbours} connected{there}: none sends it"
    most = sorted(others, key=lambda key: (-others[key], key))[:_MOST_NAMED]
    named = ", ".join(f"{key} ({others[key]} a second)" for key in most)
    return f"{waits}; hears {named} instead{_advice(wish, most)}"


def _advice(wish: Wish, keys: list[str]) -> str:
    for key in keys:
        for ending, words in (wish.advice or {}).items():
            if key.endswith(ending):
                return ": " + words.format(first=key.partition("/")[0], key=key)
    return ""
