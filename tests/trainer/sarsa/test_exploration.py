"""Exploration: the random stream, the greedy choice, the ε-greedy one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime.choice import Hold
from reflexarc_runtime.choice import choose as choose_on_a_robot
from reflexarc_trainer.sarsa.exploration import (
    FREE,
    choose,
    expected_value,
    greedy,
    new_streams,
    uniform,
    winner,
)

MASK = (1 << 64) - 1


def splitmix64(state: int) -> tuple[int, int]:
    """The published algorithm in Python's own integers."""
    state = (state + 0x9E3779B97F4A7C15) & MASK
    z = state
    z = ((z ^ (z >> 30)) * 0xBF58476D1CE4E5B9) & MASK
    z = ((z ^ (z >> 27)) * 0x94D049BB133111EB) & MASK
    return state, z ^ (z >> 31)


def test_stream_is_splitmix64() -> None:
    streams = new_streams(9, 3)
    state, others = int(streams[1]), streams[[0, 2]].copy()
    for _ in range(100):
        state, z = splitmix64(state)
        assert uniform(streams, 1) == (z >> 11) * 2.0**-53
    assert int(streams[1]) == state
    assert np.array_equal(streams[[0, 2]], others)


def test_streams_of_different_seeds_and_agents_differ() -> None:
    assert len({int(word) for seed in range(100) for word in new_streams(seed, 5)}) == 500


def test_of_equal_values_the_first_wins() -> None:
    assert winner(np.array([[0.0, 1.0], [0.0, 1.0], [9.0, 1.0]]), 1) == 0
    assert winner(np.array([[0.0], [1.0], [1.0]]), 0) == 1


def test_epsilon_is_the_share_of_random_actions() -> None:
    streams, q_values = new_streams(0), np.array([[0.0], [1.0], [0.0]])
    chosen = np.array([choose(q_values, 0, 0.3, streams, 0, FREE, 0.0, 0.0) for _ in range(20_000)])
    shares = np.bincount(chosen, minlength=3) / len(chosen)
    np.testing.assert_allclose(shares, [0.1, 0.8, 0.1], atol=0.01)


def test_without_epsilon_the_winner_is_chosen() -> None:
    streams, q_values = new_streams(0), np.array([[0.0], [0.0], [1.0]])
    assert {choose(q_values, 0, 0.0, streams, 0, FREE, 0.0, 0.0) for _ in range(100)} == {2}


@given(
    st.lists(st.integers(-8, 8), min_size=2, max_size=5),
    st.integers(-1, 1),
    st.sampled_from([0.0, 0.25, 0.5, 1.0]),
    st.sampled_from([0.0, 1.0, 2.5, 6.0]),
)
def test_the_greedy_choice_is_what_a_robot_would_do(
    values: list[int], in_force: int, margin: float, least_lead: float
) -> None:
    """Against the rule in Python, which the controller has."""
    q_values = [float(q) for q in values]
    held = None if in_force == FREE else Hold(in_force, 0)
    best = int(np.argmax(q_values))
    wanted = choose_on_a_robot(held, q_values, best, 9, 1, margin, least_lead).action
    column = np.array([q_values]).T
    assert greedy(column, 0, in_force, margin, least_lead) == wanted


def test_a_random_action_asks_for_no_lead() -> None:
    streams, q_values = new_streams(0), np.array([[0.0], [1.0], [0.0]])
    chosen = [choose(q_values, 0, 0.3, streams, 0, 0, 1.0, 9.0) for _ in range(20_000)]
    shares = np.bincount(np.array(chosen), minlength=3) / len(chosen)
    np.testing.assert_allclose(shares, [0.8, 0.1, 0.1], atol=0.01)


def test_expected_value_is_the_mean_over_what_is_chosen() -> None:
    q_values, streams = np.array([[1.0], [4.0], [-2.0]]), new_streams(1)
    chosen = [choose(q_values, 0, 0.4, streams, 0, FREE, 0.0, 0.0) for _ in range(50_000)]
    assert expected_value(q_values, 0, 0.4, 1) == pytest.approx(0.6 * 4.0 + 0.4 * 1.0)
    assert np.mean(q_values[chosen, 0]) == pytest.approx(2.8, abs=0.05)
