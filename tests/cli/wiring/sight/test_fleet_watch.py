"""How long a listing waits until every robot must have been heard."""

from collections.abc import Callable
from typing import Any

import pytest

from reflexarc.wiring.sight import fleet_watch
from reflexarc.wiring.sight.fleet_watch import FleetWatch
from support.fleet_words import SECOND, lease, status


class HeardBus:
    """Remembers who listens to what."""

    def __init__(self) -> None:
        self.heard: dict[str, Callable[..., None]] = {}

    def subscribe_to_key(self, key: str, deliver: Any) -> None:
        self.heard[key] = deliver

    watch_tokens = subscribe_to_key


class Scene:
    """A time that passes only while somebody sleeps, and what happens in it."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now_s, self.events, self.bus = 0.0, dict[float, Callable[[], None]](), HeardBus()
        monkeypatch.setattr(fleet_watch.time, "sleep", self._sleep)
        self.watch = FleetWatch(self.bus, lambda: round(self.now_s * SECOND))  # type: ignore[arg-type]

    def says(self, at_s: float, robot: str) -> None:
        word = status(robot, at_s=at_s)
        self.events[at_s] = lambda: self.bus.heard["*/status"](word)

    def _sleep(self, seconds: float) -> None:
        self.now_s += seconds
        for at_s in [at_s for at_s in self.events if at_s <= self.now_s]:
            self.events.pop(at_s)()

    def waited(self, patience_s: float) -> list[str]:
        self.watch.await_all(patience_s, lambda: False)
        return [one.robot for one in self.watch.view().robots]


@pytest.fixture
def scene(monkeypatch: pytest.MonkeyPatch) -> Scene:
    return Scene(monkeypatch)


def test_nobody_is_waited_for_until_the_patience_ends(scene: Scene):
    assert scene.waited(3.0) == []
    assert scene.now_s == pytest.approx(3.0, abs=0.06)


def test_after_the_last_new_robot_it_waits_long_enough_for_another_word(scene: Scene):
    for at_s, robot in ((0.9, "a"), (1.8, "b"), (2.7, "c"), (4.5, "d")):
        scene.says(at_s, robot)
    assert scene.waited(1.0) == ["a", "b", "c"]
    assert scene.now_s == pytest.approx(3.9, abs=0.06)


def test_new_names_without_an_end_end_it_all_the_same(scene: Scene):
    for number in range(400):
        scene.says(number / 10, f"r{number}")
    assert len(scene.waited(1.0)) > 50
    assert scene.now_s == pytest.approx(6.0, abs=0.06)


def test_tokens_and_leases_are_words_as_well(scene: Scene):
    scene.bus.heard["*/alive/*"]("a/alive/recorder", True)
    scene.bus.heard["*/lease"](lease("b"))
    assert scene.waited(1.0) == ["a", "b"]


def test_who_announces_itself_has_longer_to_say_something(scene: Scene):
    scene.bus.heard["*/alive/*"]("a/alive/runtime", True)
    scene.says(3.3, "a")
    assert scene.waited(1.0) == ["a"]
    assert scene.now_s == pytest.approx(4.5, abs=0.06)


def test_who_announces_itself_and_says_nothing_is_not_waited_for_without_an_end(scene: Scene):
    scene.bus.heard["*/alive/*"]("a/alive/body", True)
    assert scene.waited(1.0) == ["a"]
    assert scene.now_s == pytest.approx(6.0, abs=0.06)
