"""How long a compilation will still take, on a clock that is set by hand."""

from collections.abc import Iterator
from contextlib import contextmanager

import pytest

from reflexarc_sim_bridge.native.compile_progress import Compilation, compilation, watched_by


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def test_what_is_left_is_what_was_expected_until_something_is_done() -> None:
    clock = Clock()
    told = Compilation({"step": 4.0, "look": 6.0}, clock)
    assert told.left_s == 10.0
    with told.part("step"):
        clock.now_s += 1.0
        assert (told.current, told.left_s) == ("step", 9.0)


def test_a_slow_machine_takes_longer_for_the_rest_too() -> None:
    clock = Clock()
    told = Compilation({"step": 4.0, "look": 6.0}, clock)
    with told.part("step"):
        clock.now_s += 12.0
    assert told.left_s == pytest.approx(18.0)
    with told.part("look"):
        clock.now_s += 5.0
        assert told.left_s == pytest.approx(13.0)
        clock.now_s += 500.0
        assert told.left_s == 0.0
    assert told.left_s == 0.0


def test_only_the_latest_watcher_is_told_and_only_of_what_has_parts() -> None:
    told: list[tuple[str, Compilation]] = []

    @contextmanager
    def watch(begun: Compilation) -> Iterator[None]:
        told.append(("begins", begun))
        yield
        told.append(("ends", begun))

    with compilation({"alone": 1.0}):
        pass
    with watched_by(lambda _: pytest.fail("not the latest")), watched_by(watch):
        with compilation({}):
            pass
        with compilation({"step": 1.0}) as begun:
            assert told == [("begins", begun)]
    assert [word for word, _ in told] == ["begins", "ends"]
