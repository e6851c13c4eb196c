from itertools import product

import pytest

from reflexarc_logs.judging.flip_limits import FlipLimits
from reflexarc_logs.judging.opposites import are_opposite
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_runtime.errors import UsageError


@pytest.mark.parametrize(
    ("word", "flips", "ticks", "exceeds"),
    [
        ("5%", 50, 1000, False),
        ("5%", 51, 1000, True),
        ("0.1%", 7, 7000, False),  # 0.1 has no exact float
        ("0.1%", 8, 7000, True),
        ("29%", 29, 100, False),  # 0.29 * 100 is 28.999999999999996
        ("12", 12, 13, False),
        ("12", 13, 13, True),
        ("", 1, 1000, True),
    ],
)
def test_a_share_is_exact_and_a_count_is_a_count(word, flips, ticks, exceeds):
    assert bool(FlipLimits(word).exceeded(flips, 0, ticks)) == exceeds


def test_who_limits_reversals_only_lets_other_flips_pass():
    assert FlipLimits(max_reversals=2).exceeded(900, 2, 1000) == ()
    assert FlipLimits(max_reversals=2).exceeded(900, 3, 1000) == ("3 reversals of at most 2",)


@pytest.mark.parametrize(
    "word", ["5 percent", "%", "-1", "1e3", "5%%", "nan", "5/100", "٥%", "101%"]
)
def test_a_limit_that_is_none_is_refused(word):
    with pytest.raises(UsageError, match="--max-flips: expected a count or a share"):
        FlipLimits(word)


@pytest.mark.parametrize(
    "limits",
    [
        {"margin": -0.1},
        {"margin": float("nan")},
        {"max_reversals": -1},
        {"since": "58", "until": "50"},
        {"since": "2s", "until": "2s"},
        {"since": "soon"},
        {"until": "-3"},
    ],
)
def test_limits_out_of_place_are_refused(limits):
    with pytest.raises(UsageError):
        FlipLimits(**limits)


def test_left_and_right_are_opposite_and_straight_on_is_to_none():
    stay, left, right = sideways_actions()
    assert [are_opposite(a, b) for a, b in product((stay, left, right), repeat=2)] == [
        *(False, False, False),
        *(False, False, True),
        *(False, True, False),
    ]
    turning = Action("a", 1.0, 0.0, 2.0), Action("b", 0.5, 0.0, -0.1)
    assert are_opposite(*turning)
    assert are_opposite(Action("on", 1.0, 0.0), Action("back", -0.2, 0.0))
    assert not are_opposite(Action("on", 1.0, 0.0), Action("stand", 0.0, 0.0))
