"""Holds and margins, against rules worked out by hand and a slow definition."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.choice import Hold, choose, slots_of

LEFT, STAY, RIGHT = 1, 0, 2


def chosen(winners: list[int], hold_slots: int, margin: float = 0.0) -> list[int]:
    """What is done at each slot, for winners that lead by the whole spread."""
    held, actions = None, []
    for slot, winner in enumerate(winners):
        q_values = [1.0 if action == winner else 0.0 for action in range(3)]
        held = choose(held, q_values, winner, slot, hold_slots, margin)
        actions.append(held.action)
    return actions


def test_without_hold_and_margin_the_winner_is_done():
    winners = [0, 1, 2, 2, 1, 0]
    assert chosen(winners, 0) == winners
    assert chosen(winners, 1) == winners


def test_an_action_is_done_for_its_hold_and_then_the_winner():
    #      slot  0  1  2  3  4  5  6  7
    assert chosen([1, 2, 2, 2, 2, 0, 0, 0], 3) == [1, 1, 1, 2, 2, 2, 0, 0]


def test_a_hold_is_counted_from_when_its_action_began():
    assert chosen([1, 1, 1, 2], 3) == [1, 1, 1, 2]


def test_skipped_slots_count_so_that_a_hold_is_a_time():
    held = Hold(LEFT, since_slot=10)
    assert choose(held, [0.0, 0.0, 1.0], RIGHT, 12, 3, 0.0) == held
    assert choose(held, [0.0, 0.0, 1.0], RIGHT, 13, 3, 0.0) == Hold(RIGHT, 13)


@pytest.mark.parametrize(
    ("q_values", "action"),
    [
        ([0.0, 0.7, 1.0], LEFT),  # leads by 0.3 of a spread of 1
        ([0.0, 0.4, 1.0], RIGHT),  # by 0.6
        ([0.0, 0.5, 1.0], RIGHT),  # by exactly the margin, which is enough
        ([5.0, 5.7, 6.0], LEFT),  # the same, elsewhere
        ([0.0, 70.0, 100.0], LEFT),  # and larger: a share has no unit
    ],
)
def test_another_action_must_win_by_the_margin(q_values, action):
    assert choose(Hold(LEFT, 0), q_values, RIGHT, 9, 1, 0.5).action == action


@pytest.mark.parametrize(
    ("q_values", "action"),
    [
        ([0.0, 0.75, 1.0], RIGHT),  # leads by 0.25, the least lead
        ([-9.0, 0.8125, 1.0], LEFT),  # by less, of any spread
        ([7.0, 7.75, 8.0], RIGHT),  # the same, elsewhere
        ([0.0, 0.5, 0.7], LEFT),  # half as large: a lead has the unit of the Q-values
    ],
)
def test_another_action_must_win_by_the_least_lead(q_values, action):
    assert choose(Hold(LEFT, 0), q_values, RIGHT, 9, 1, 0.0, 0.25).action == action


def test_a_lead_must_be_enough_by_share_and_by_unit():
    values = [0.0, 0.75, 1.0]  # a lead of 0.25, a quarter of the spread
    done = {
        (margin, least): choose(Hold(LEFT, 0), values, RIGHT, 9, 1, margin, least).action
        for margin in (0.25, 0.3)
        for least in (0.25, 0.3)
    }
    assert done == {(0.25, 0.25): RIGHT, (0.25, 0.3): LEFT, (0.3, 0.25): LEFT, (0.3, 0.3): LEFT}


def test_after_a_release_the_winner_is_done_whatever_its_margin():
    assert choose(None, [0.0, 1.0, 1.0 + 1e-9], RIGHT, 9, 100, 1.0) == Hold(RIGHT, 9)


@pytest.mark.parametrize(
    ("seconds", "rate_hz", "slots"),
    [(0.0, 50, 0), (0.1, 50, 5), (0.1, 10, 1), (0.7, 10, 7), (0.11, 50, 6), (0.3, 1 / 0.1, 3)],
)
def test_a_time_in_slots_is_rounded_up_and_not_by_the_error_of_a_float(seconds, rate_hz, slots):
    assert slots_of(seconds, rate_hz) == slots


def slow_choice(rows: np.ndarray, hold: int, margin: float, least_lead: float) -> list[int]:
    """The definition, in words: look back to when the present action began."""
    actions: list[int] = []
    for slot, row in enumerate(rows):
        winner = int(np.argmax(row))
        if not actions:
            actions.append(winner)
            continue
        now = actions[-1]
        age = next((i for i, a in enumerate(reversed(actions)) if a != now), len(actions))
        may_change = age >= hold
        lead = float(row[winner]) - float(row[now])
        is_better = lead >= max(margin * float(max(row) - min(row)), least_lead)
        actions.append(winner if slot and may_change and is_better else now)
    return actions


@given(
    st.lists(st.lists(st.integers(-8, 8), min_size=3, max_size=3), min_size=1, max_size=30),
    st.integers(0, 6),
    st.sampled_from([0.0, 0.25, 0.5, 1.0]),
    st.sampled_from([0.0, 1.0, 2.5, 6.0]),
)
def test_it_is_the_slow_definition(rows, hold, margin, least_lead):
    held, actions = None, []
    for slot, row in enumerate(rows):
        winner = int(np.argmax(row))
        held = choose(held, [float(q) for q in row], winner, slot, hold, margin, least_lead)
        actions.append(held.action)
    assert actions == slow_choice(np.array(rows, float), hold, margin, least_lead)
