"""Holds and margins on arrays against the controller's own rule, tick by tick."""

from dataclasses import replace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_logs.replaying.comparison import are_close, is_close
from reflexarc_logs.replaying.runs.held_rows import done_rows, held_rows
from reflexarc_runtime.choice import Hold, choose
from support.recordings import CONTRACT

VALUES = st.lists(st.sampled_from([0.0, 0.5, 1.0, 1.25, -2.0]), min_size=3, max_size=3)
HELD = st.one_of(st.none(), st.builds(Hold, st.integers(0, 2), st.integers(0, 3)))
TICKS = st.lists(st.tuples(st.integers(0, 2), VALUES, st.integers(1, 3)), min_size=1, max_size=12)


@settings(max_examples=200, deadline=None)
@given(HELD, TICKS, st.sampled_from([(0.0, 0.0, 0.0), (0.1, 0.0, 0.0), (0.06, 0.2, 0.3)]))
def test_arrays_choose_as_the_controller_does(
    held: Hold | None, ticks: list[tuple[int, list[float], int]], kept: tuple[float, float, float]
) -> None:
    contract = replace(CONTRACT, hold_s=kept[0], margin=kept[1], least_lead=kept[2])
    actions = np.array([action for action, _, _ in ticks])
    slots = 4 + np.cumsum([step for _, _, step in ticks])
    q_values = np.array([values for _, values, _ in ticks], np.float32)
    winners = q_values.argmax(1)
    rows, behind = held_rows(held, actions, slots)
    done = done_rows(rows, q_values, winners, slots, contract)
    for row, action in enumerate(actions.tolist()):
        assert rows.at(row) == held
        slot, least = int(slots[row]), (contract.hold_slots, contract.margin, contract.least_lead)
        expected = choose(held, q_values[row].tolist(), int(winners[row]), slot, *least)
        assert done[row] == (expected.action if contract.keeps_actions else winners[row])
        held = held if held is not None and held.action == action else Hold(action, slot)
    assert behind == held


ANY = st.floats(width=32)


@settings(max_examples=300, deadline=None)
@given(st.lists(st.tuples(ANY, st.one_of(ANY, st.just(0.0))), min_size=1), st.floats(0, 0.5))
def test_close_on_arrays_is_close_one_by_one(pairs: list[tuple[float, float]], tol: float) -> None:
    old, new = np.array(pairs, np.float32).T
    expected = [is_close(float(a), float(b), tol) for a, b in zip(old, new, strict=True)]
    assert are_close(old, new, tol).tolist() == expected
