"""What a waiting command says of the silence: as a table, and with a bus that nobody answers."""

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import pytest

from reflexarc.wiring import waiting
from reflexarc.wiring.waiting import Surroundings, Waiting, Wish, explained
from support.processes import wait_until

RETINAS = Wish(
    "reflexarc run",
    "retinas",
    "robot0/retina",
    advice={"robot0/scan": "--input scan", "/retina": "another robot, --robot {first}?"},
)
BODY = Wish("reflexarc arm", "a body", "robot0/lease")
BEGINS = "reflexarc run: waits for retinas on robot0/retina; "


@pytest.mark.parametrize(
    ("heard", "tokens", "neighbours", "ends"),
    [
        ({}, (), 0, "nobody is connected"),
        ({}, (), 2, "2 connected: none sends it"),
        (
            {},
            ("robot0/alive/body",),
            1,
            "1 connected, of which robot0/alive/body: none sends it",
        ),
        ({"robot0/retina": 50}, (), 1, "1 connected: none sends it"),
        ({"robot0/scan": 10}, (), 1, "hears robot0/scan (10 a second) instead: --input scan"),
        (
            {"rover/retina": 50, "rover/pose": 50},
            (),
            1,
            "hears rover/retina (50 a second), rover/pose (50 a second) instead: another robot, "
            "--robot rover?",
        ),
        (
            {f"rover/{n}": 9 for n in range(9)},
            (),
            1,
            "hears rover/0 (9 a second), rover/1 (9 a second), rover/2 (9 a second), "
            "rover/3 (9 a second) instead",
        ),
        # What can be advised about comes first, however seldom it is.
        (
            {**{f"rover/{n}": 99 for n in range(9)}, "robot0/scan": 1},
            (),
            1,
            "hears robot0/scan (1 a second), rover/0 (99 a second), rover/1 (99 a second), "
            "rover/2 (99 a second) instead: --input scan",
        ),
        (
            {"a\x1b[2J\n/retina": 1},
            (),
            1,
            "hears a?[2J?/retina (1 a second) instead: another robot, --robot a?[2J??",
        ),
    ],
)
def test_the_line(heard: dict[str, int], tokens: tuple[str, ...], neighbours: int, ends: str):
    assert explained(RETINAS, Surroundings(heard, tokens, neighbours)) == BEGINS + ends


@pytest.mark.parametrize(
    ("key", "ends"),
    [
        ("rover/lease", "instead: another robot, --robot rover?"),
        ("robot0/pose", "instead"),  # of the robot that was asked for
        ("robot00/lease", "instead: another robot, --robot robot00?"),
    ],
)
def test_only_another_robot_is_called_another_one(key: str, ends: str):
    assert explained(BODY, Surroundings({key: 1}, (), 1)).endswith(f"(1 a second) {ends}")


def test_a_key_of_a_stranger_fills_no_screen():
    assert len(explained(BODY, Surroundings({"x" * 60_000: 1}, ("y" * 60_000,), 1))) < 400


@dataclass
class QuietBus:
    """A bus on which these are heard."""

    heard: dict[str, int] = field(default_factory=dict)
    neighbours: int = 0
    loneliness: str = "nobody is connected"
    looked: int = 0

    def overhear(self, around: Iterable[str], wait: Callable[[], object]) -> dict[str, int]:
        self.looked += 1
        wait()
        return dict(self.heard)

    def tokens(self, expression: str) -> list[str]:
        return []


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """What reaches the terminal, from a command that is as impatient as a test."""
    lines: list[str] = []
    monkeypatch.setattr(waiting, "PATIENCE_S", 0.02)
    monkeypatch.setattr(waiting, "LISTEN_S", 0.01)
    monkeypatch.setattr(waiting, "AGAIN_S", 0.02)
    monkeypatch.setattr(waiting.aside, "print", lambda line, **_: lines.append(line))
    return lines


def threads() -> list[str]:
    return [thread.name for thread in threading.enumerate()]


def test_it_speaks_once_and_again_only_of_what_is_new(said: list[str]):
    bus: Any = QuietBus()
    with Waiting(bus, BODY, lambda: False):
        wait_until(lambda: bus.looked > 4, "looks", 10.0)
        assert said == ["reflexarc arm: waits for a body on robot0/lease; nobody is connected"]
        bus.neighbours, bus.heard = 1, {"rover/pose": 49}
        wait_until(lambda: len(said) > 1, "a second line", 10.0)
        bus.heard = {"rover/pose": 51}  # another rate is no news
        again = bus.looked + 4
        wait_until(lambda: bus.looked > again, "looks", 10.0)
        bus.heard = {}
        again = bus.looked + 4
        wait_until(lambda: bus.looked > again, "looks", 10.0)
    assert len(said) == 2
    assert "waiting" not in threads()


def test_nothing_is_said_when_it_comes(said: list[str]):
    bus: Any = QuietBus()
    came = threading.Event()
    with Waiting(bus, BODY, lambda: came.is_set()):
        came.set()
        wait_until(lambda: "waiting" not in threads(), "the end of the thread", 10.0)
    assert said == []


def test_the_end_does_not_wait_for_it(said: list[str], monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(waiting, "LISTEN_S", 600.0)
    bus: Any = QuietBus()
    with Waiting(bus, BODY, lambda: False):
        wait_until(lambda: bus.looked == 1, "a look", 10.0)
    assert "waiting" not in threads()
    assert said == []
