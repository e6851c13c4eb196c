"""What is said again and again comes at its times, and nothing is caught up."""

from itertools import pairwise

import pytest

from reflexarc.commands.service import top


class Clock:
    """Moves when somebody sleeps."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def monotonic(self) -> float:
        return self.now_s

    def sleep(self, seconds: float) -> None:
        self.now_s += seconds


@pytest.mark.parametrize("blocks_in", ["itself", "the machine"])
def test_after_a_pause_there_is_no_burst(monkeypatch: pytest.MonkeyPatch, blocks_in: str):
    clock, said_s = Clock(), list[float]()
    monkeypatch.setattr(top, "time", clock)

    def say() -> None:
        said_s.append(clock.now_s)
        if len(said_s) == 3 and blocks_in == "itself":  # nobody reads the pipe
            clock.now_s += 10.4

    def should_stop() -> bool:
        if len(said_s) == 3 and clock.now_s < 3.2 and blocks_in != "itself":  # Ctrl-Z
            clock.now_s += 10.4
        return clock.now_s > 20.0

    top._every(1.0, should_stop, say)
    assert said_s[:3] == pytest.approx([1.0, 2.0, 3.0], abs=0.11)
    apart_s = [b - a for a, b in pairwise(said_s[3:])]
    assert min(apart_s) > 0.4, said_s
    assert sum(each < 0.85 for each in apart_s) <= 1  # from a late one to the next full second
    assert len(said_s) <= 11
