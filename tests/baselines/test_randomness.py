import numpy as np
import pytest

from reflexarc_baselines.randomness import MULTIPLIER, PRIME, drawn
from reflexarc_runtime.arrays import RetinaBatch

P, A = 16_777_213, 7_138_531


def dark(agents: int = 1) -> RetinaBatch:
    return np.zeros((agents, 1, 1, 16, 1), np.uint8)


def test_in_the_dark_it_is_lehmers_generator() -> None:
    """From s = 0 the first m is p − 1; then s follows a·s mod p, in whole numbers."""
    state, expected = np.zeros(1, np.float32), P - 1
    for _ in range(50):
        uniform, state = drawn(state, dark())
        expected = A * expected % P
        assert int(state[0]) == expected
        assert uniform[0] == pytest.approx((expected - 1) / (P - 1), abs=1e-7)


def test_no_number_comes_back_before_all_had_their_turn() -> None:
    """p is a prime, and no power of a by a true divisor of p − 1 = 2²·3·23·89·683 is 1."""
    assert (PRIME, MULTIPLIER) == (P, A)
    assert all(P % divisor for divisor in range(2, 4097))
    assert P - 1 == 2**2 * 3 * 23 * 89 * 683
    assert all(pow(A, (P - 1) // prime, P) != 1 for prime in (2, 3, 23, 89, 683))


def test_what_is_seen_is_stirred_in_by_its_digits() -> None:
    retina = dark()
    retina[0, 0, 0, [2, 5], 0] = 200, 7
    _, state = drawn(np.array([123.0], np.float32), retina)
    stirred = 123 + 200 * pow(A, 3, P) + 7 * pow(A, 6, P)
    # The hash is taken modulo p before it is added, and the sum modulo p − 1.
    mixed = 1 + (123 + (stirred - 123) % P - 1) % (P - 1)
    assert int(state[0]) == A * mixed % P


def test_agents_part_as_soon_as_one_ray_differs_by_one_step() -> None:
    retinas = dark(17)
    retinas[np.arange(16), 0, 0, np.arange(16), 0] = 1
    uniform, _ = drawn(np.zeros(17, np.float32), retinas)
    assert len(set(uniform.tolist())) == 17


def test_draws_fill_the_unit_interval_evenly_and_tell_nothing_of_the_next_one() -> None:
    """Chi-square of 100 × 1,000 draws in 20 × 20 cells of neighbours: 399 ± 28 degrees."""
    retinas = np.random.default_rng(3).integers(0, 256, (1000, 1, 1, 16, 1), dtype=np.uint8)
    state, draws = np.zeros(1000, np.float32), []
    for _ in range(101):
        uniform, state = drawn(state, retinas)
        draws.append(uniform)
    values = np.array(draws)
    assert ((values >= 0.0) & (values < 1.0)).all()
    cells = np.histogram2d(values[:-1].ravel(), values[1:].ravel(), 20, [[0, 1], [0, 1]])[0]
    assert abs(((cells - 250.0) ** 2 / 250.0).sum() - 399.0) < 4 * 28.2


def test_states_are_whole_numbers_that_float32_holds() -> None:
    """The greatest state as well: p − 1 is drawn as the greatest float below 1."""
    before = pow(A, -1, P) * (P - 1) % P
    uniform, state = drawn(np.array([before], np.float32), dark())
    assert state[0] == P - 1
    assert uniform[0] == np.nextafter(np.float32(1.0), np.float32(0.0))
