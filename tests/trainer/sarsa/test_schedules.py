"""A linear schedule, at its ends and between them."""

import pytest

from reflexarc_trainer.sarsa.schedules import linear


def test_epsilon_falls_linearly_and_then_stays() -> None:
    values = [linear(step, 1.0, 0.02, 100.0) for step in (0, 25, 50, 100, 101, 10**9)]
    assert values == pytest.approx([1.0, 0.755, 0.51, 0.02, 0.02, 0.02])


def test_epsilon_without_a_decay_is_its_end() -> None:
    assert linear(0, 1.0, 0.02, 0.0) == 0.02
