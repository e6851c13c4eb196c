"""The judge of what was seen of robots: each kind of untruth, and the truth."""

from dataclasses import replace

import pytest

from support.fleet_judge import LoggedRobot, SeenRobot, untrue

MS = 1_000_000
PERIOD_NS = 20 * MS
TICKS = 200
LOST = 120
"""One slot has no tick behind this many."""
LOGGED = LoggedRobot(
    "robot3",
    [n * PERIOD_NS + (PERIOD_NS if n > LOST else 0) for n in range(TICKS)],
    ["NO_INPUT"] * 10 + ["OK"] * (TICKS - 10),
    ["a"] * 60 + ["b"] * (TICKS - 60),
    [n + 1 + (n > LOST) for n in range(TICKS)],
    [(0, ""), (200 * MS, "11"), (2500 * MS, "22")],
)
SEEN = SeenRobot("robot3", 2000 * MS, 100, 50.0, {"NO_INPUT": 10, "OK": 90}, "b", "11")


def test_the_truth_is_not_held_against_anybody():
    assert untrue(SEEN, LOGGED) == []
    later = replace(SEEN, ticks=150, verdicts={"NO_INPUT": 10, "OK": 140}, skipped=1)
    assert untrue(replace(later, rate_hz=49.0), LOGGED) == []


@pytest.mark.parametrize(
    ("lie", "words"),
    [
        ({"ticks": 201}, "its log has 200"),
        ({"ticks": 0}, "its log has 200"),
        ({"verdicts": {"OK": 100}}, "verdicts"),
        ({"verdicts": {"NO_INPUT": 10, "OK": 91}}, "verdicts"),
        ({"policy_hash": "a"}, "policy a"),
        ({"rate_hz": 47.0}, "47.00 Hz, logged 50.00 to 50.00"),
        ({"skipped": 1}, "1 slots skipped, logged 0"),
        ({"holder": "22"}, "lease of 22"),
        ({"holder": ""}, "lease of nobody"),
    ],
)
def test_each_untruth_is_one_line_and_says_where(lie: dict[str, object], words: str):
    (line,) = untrue(replace(SEEN, **lie), LOGGED)  # type: ignore[arg-type]  # fields by name
    assert line.startswith("robot3")
    assert words in line


def test_a_lease_that_changes_just_then_may_be_seen_as_either():
    for holder in ("11", "22"):
        assert untrue(replace(SEEN, at_ns=2400 * MS, holder=holder), LOGGED) == []


def test_a_second_with_a_hole_has_the_rate_of_the_period_that_the_runtime_chose():
    hole_ns = 700 * MS
    wake_ns = [n * PERIOD_NS + (hole_ns if n >= 60 else 0) for n in range(TICKS)]
    holed = replace(LOGGED, wake_ns=wake_ns)
    since_60 = replace(SEEN, ticks=90, verdicts={"NO_INPUT": 10, "OK": 80}, policy_hash="b")
    for first in (55, 60, 40):  # the first tick of the period
        hz = (89 - first) * 1e9 / (wake_ns[89] - wake_ns[first])
        assert untrue(replace(since_60, rate_hz=hz), holed) == []
    assert untrue(replace(since_60, rate_hz=60.0), holed) != []
