import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_baselines.history.wires import Inhibitor, Messages, Suppressor

PERIOD_S = 0.1
Times = list[bool]


def messages(value: float, is_sent: bool) -> Messages:
    return Messages(np.array([value if is_sent else 0.0], np.float32), np.array([is_sent]))


def suppressed(above: Times, below: Times, time_constant_s: float) -> list[float | None]:
    """What arrives, decision by decision; the line sends −k at decision k, from above comes k."""
    wire, state = Suppressor(time_constant_s, PERIOD_S), np.zeros((1, 2), np.float32)
    arrived: list[float | None] = []
    for k, (is_above, is_below) in enumerate(zip(above, below, strict=True), 1):
        came, state = wire.passed(messages(-k, is_below), messages(k, is_above), state)
        arrived.append(float(came.values[0]) if came.is_sent[0] else None)
    return arrived


def test_a_message_from_above_replaces_the_lines_own_for_the_time_constant() -> None:
    above = [False, True, False, False, False]
    assert suppressed(above, [True] * 5, 0.2) == [-1, 2, 2, -4, -5]
    assert suppressed(above, [True] * 5, 0.3) == [-1, 2, 2, 2, -5]
    assert suppressed(above, [True] * 5, 0.1) == [-1, 2, -3, -4, -5]


@given(st.lists(st.tuples(st.booleans(), st.booleans()), max_size=30), st.integers(1, 5))
def test_a_suppressor_holds_the_last_message_that_is_younger_than_its_time(
    sent: list[tuple[bool, bool]], periods: int
) -> None:
    """By the definition: a message at t holds [t, t + τ)."""
    above, below = [a for a, _ in sent], [b for _, b in sent]
    expected: list[float | None] = []
    for k in range(len(sent)):
        young = [j for j in range(k + 1) if above[j] and k - j < periods]
        expected.append(young[-1] + 1 if young else -(k + 1) if below[k] else None)
    assert suppressed(above, below, periods * PERIOD_S) == expected


@given(st.lists(st.booleans(), max_size=30), st.integers(1, 5))
def test_an_inhibitor_blanks_the_line_for_its_time(above: Times, periods: int) -> None:
    wire, state = Inhibitor(periods * PERIOD_S, PERIOD_S), np.zeros((1, 1), np.float32)
    for k, is_above in enumerate(above):
        came, state = wire.passed(messages(1.0, True), np.array([is_above]), state)
        assert bool(came.is_sent[0]) is not any(above[max(0, k - periods + 1) : k + 1])


@pytest.mark.parametrize(("period_s", "decisions"), [(0.1, 2), (0.02, 10)])
def test_the_time_constant_is_in_seconds_at_any_rate(period_s: float, decisions: int) -> None:
    wire, state = Suppressor(0.2, period_s), np.zeros((1, 2), np.float32)
    held = 0
    for k in range(20):
        came, state = wire.passed(messages(-1.0, True), messages(1.0, k == 0), state)
        held += int(came.values[0] > 0.0)
    assert held == decisions
