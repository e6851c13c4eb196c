"""Running errors: the true error of float32 never exceeds them, whatever the order of summation."""

from collections.abc import Callable
from fractions import Fraction

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_trainer.policy.rounding import running_error
from reflexarc_trainer.policy.rounding.running_error import Running, affine, exactly

Pair = tuple[npt.NDArray[np.float32], Running]


def disturbed(seed: int, size: int, spread: float = 1.0) -> Pair:
    """Float32 values that are off from exact ones, by no more than is known."""
    rng = np.random.default_rng(seed)
    exact = rng.normal(scale=spread, size=size)
    seen = (exact * (1 + rng.normal(scale=1e-6, size=size))).astype(np.float32)
    return seen, Running(exact, np.abs(seen - exact))


def assert_holds(seen: npt.NDArray[np.float32], running: Running) -> None:
    assert np.all(np.abs(seen.astype(np.float64) - running.value) <= running.error)


@pytest.mark.parametrize(
    ("by_numpy", "name"),
    [(np.add, "add"), (np.subtract, "subtract"), (np.multiply, "multiply"), (np.divide, "divide")],
)
@given(seed=st.integers(0, 10**6), spread=st.sampled_from([1e-20, 1e-3, 1.0, 1e10]))
@settings(deadline=None, max_examples=50)
def test_two_operands(by_numpy: np.ufunc, name: str, seed: int, spread: float) -> None:
    (a, exact_a), (b, exact_b) = disturbed(seed, 50), disturbed(seed + 1, 50, spread)
    operation: Callable[..., Running] = getattr(running_error, name)
    assert_holds(by_numpy(a, b), operation(exact_a, exact_b))


@given(seed=st.integers(0, 10**6), spread=st.sampled_from([1e-3, 1.0, 30.0]))
@settings(deadline=None, max_examples=50)
def test_activations(seed: int, spread: float) -> None:
    x, exact = disturbed(seed, 50, spread)
    assert_holds(np.maximum(x, 0), running_error.relu(exact))
    assert_holds(np.tanh(x), running_error.tanh(exact))
    with np.errstate(over="ignore"):
        assert_holds(1 / (1 + np.exp(-x)), running_error.sigmoid(exact))


@given(
    seed=st.integers(0, 10**6),
    terms=st.integers(1, 40),
    spread=st.sampled_from([1e-3, 1.0, 1e3]),
    sign=st.booleans(),
)
@settings(deadline=None, max_examples=100)
def test_sums_in_any_order(seed: int, terms: int, spread: float, sign: bool) -> None:
    rng = np.random.default_rng(seed)
    x, exact = disturbed(seed, terms)
    weights, bias = (rng.normal(scale=spread, size=n).astype(np.float32) for n in (terms, 1))
    if sign:
        weights, bias = np.abs(weights), np.abs(bias)
    result = affine(exact, weights.astype(np.float64)[:, np.newaxis], bias.astype(np.float64))
    products = [*(x * weights), bias[0]]
    for order in (sorted(products), rng.permutation(products), sorted(products, key=abs)):
        total = np.float32(0)
        for term in order:
            total = np.float32(total + np.float32(term))
        assert abs(float(total) - result.value[0]) <= result.error[0]


def test_a_sum_is_exact_but_for_double_precision() -> None:
    rng = np.random.default_rng(0)
    x, weights = rng.normal(size=(2, 9))
    value = affine(exactly(x), weights[:, np.newaxis]).value[0]
    exact = sum(Fraction(a) * Fraction(b) for a, b in zip(x, weights, strict=True))
    assert abs(Fraction(float(value)) - exact) < Fraction(1, 10**14)


def test_what_has_no_bound_says_so() -> None:
    near_zero = Running(np.array([1e-8]), np.array([1e-7]))
    assert running_error.divide(exactly(np.ones(1)), near_zero).error[0] == np.inf
    huge = exactly(np.full(1, 1e38))
    assert running_error.multiply(huge, huge).error[0] == np.inf
