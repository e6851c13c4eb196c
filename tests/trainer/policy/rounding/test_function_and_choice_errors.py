"""Running errors of functions and of jumps: float32 never differs by more, at ties neither."""

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from onnx import TensorProto

from reflexarc_trainer.policy.rounding import choice_errors as choice
from reflexarc_trainer.policy.rounding import function_errors as functions
from reflexarc_trainer.policy.rounding import running_error
from reflexarc_trainer.policy.rounding.running_error import Running, exactly

SIZE = 60
seeds = st.integers(0, 10**6)

FUNCTIONS: dict[str, tuple[Any, Any, float, float]] = {
    "asin": (np.arcsin, functions.monotone(np.arcsin, -1.0, 1.0), -0.99, 0.99),
    "acos": (np.arccos, functions.monotone(np.arccos, -1.0, 1.0), -0.99, 0.99),
    "atan": (np.arctan, functions.monotone(np.arctan), -50.0, 50.0),
    "exp": (np.exp, functions.monotone(np.exp), -9.0, 9.0),
    "sqrt": (np.sqrt, running_error.square_root, 0.0, 9.0),
    "sin": (np.sin, functions.wave(np.sin), -20.0, 20.0),
    "cos": (np.cos, functions.wave(np.cos), -20.0, 20.0),
    "abs": (np.abs, functions.absolute, -1.0, 1.0),
    "floor": (np.floor, choice.floor, -3.0, 3.0),
    "sign": (np.sign, choice.sign, -1.0, 1.0),
}
COMPARISONS = [np.less, np.less_equal, np.greater, np.greater_equal, np.equal]


def disturbed(seed: int, low: float = -1.0, high: float = 1.0) -> tuple[Any, Running]:
    """Float32 values that are off by no more than is known; some of them exact, many alike."""
    rng = np.random.default_rng(seed)
    drawn = rng.uniform(low, high, SIZE)
    exact = np.where(rng.random(SIZE) < 0.6, np.clip(np.round(drawn), low, high), drawn)
    exact = exact.astype(np.float32).astype(np.float64)
    off = rng.choice([0.0, 0.0, 1e-6], SIZE) * rng.normal(size=SIZE)
    seen = np.clip(exact + off, low, high).astype(np.float32)
    return seen, Running(exact, np.abs(seen - exact))


def assert_holds(seen: npt.NDArray[Any], running: Running) -> None:
    off = np.abs(seen.astype(np.float64) - running.value)
    assert np.all(off <= running.error), (off - running.error).max()


@pytest.mark.parametrize("name", FUNCTIONS)
@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_a_function_of_one_number(name: str, seed: int) -> None:
    by_numpy, rule, low, high = FUNCTIONS[name]
    seen, running = disturbed(seed, low, high)
    assert_holds(by_numpy(seen), rule(running))


@given(seed=seeds, exponent=st.sampled_from([0.5, 1.5, 3.0]))
@settings(deadline=None, max_examples=40)
def test_a_power(seed: int, exponent: float) -> None:
    seen, running = disturbed(seed, 0.0, 4.0)
    known = exactly(np.array(exponent))
    assert_holds(seen ** np.float32(exponent), functions.power(running, known))
    with np.errstate(invalid="ignore"):  # as where the bound is computed
        below = functions.power(Running(-running.value - 1.0, running.error), known)
    assert np.isinf(below.error).all()


@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_the_larger_and_the_smaller(seed: int) -> None:
    (a, known_a), (b, known_b) = disturbed(seed), disturbed(seed + 1)
    assert_holds(np.maximum(a, b), functions.larger(known_a, known_b))
    assert_holds(np.minimum(a, b), functions.smaller(known_a, known_b))
    # What lies clearly below does not count.
    clear = functions.larger(known_a, Running(known_b.value - 9.0, known_b.error + 1.0))
    np.testing.assert_array_equal(clear.error, known_a.error)


@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_sums_means_and_extremes_along_an_axis(seed: int) -> None:
    seen, running = disturbed(seed, -100.0, 100.0)
    table, known = seen.reshape(6, 10), running.map(lambda part: part.reshape(6, 10))
    along = {"axes": [1], "keepdims": 0}
    last_first = table[:, ::-1].cumsum(axis=1, dtype=np.float32)[:, -1]
    for total in (table.sum(axis=1), last_first):
        assert_holds(total, functions.total({"keepdims": 0}, known, exactly(np.array([1]))))
        assert_holds(total / np.float32(10.0), functions.mean(along, known))
        assert_holds(total * np.float32(0.1), functions.mean(along, known))
    assert_holds(table.max(axis=1), functions.extreme(np.max)(along, known))
    assert_holds(table.min(axis=1), functions.extreme(np.min)(along, known))


@pytest.mark.parametrize("by_numpy", COMPARISONS)
@given(seed=seeds)
@settings(deadline=None, max_examples=40)
def test_a_truth_is_open_where_float32_may_say_otherwise(by_numpy: np.ufunc, seed: int) -> None:
    (a, known_a), (b, known_b) = disturbed(seed), disturbed(seed + 1)
    (c, known_c), (d, known_d) = disturbed(seed + 2), disturbed(seed + 3)
    one, other = by_numpy(a, b), by_numpy(c, d)
    known_one = choice.comparison(by_numpy)(known_a, known_b)
    known_other = choice.comparison(by_numpy)(known_c, known_d)
    assert_holds(one, known_one)
    assert_holds(one & other, choice.both(known_one, known_other))
    assert_holds(one | other, choice.either(known_one, known_other))
    assert_holds(~one, choice.inverse(known_one))
    assert_holds(np.where(one, c, d), choice.chosen(known_one, known_c, known_d))


def test_equal_numbers_that_are_exact_leave_nothing_open() -> None:
    numbers = exactly(np.array([0.0, 1.5], np.float32))
    assert not choice.comparison(np.less)(numbers, numbers).error.any()


@given(seed=seeds)
@settings(deadline=None, max_examples=60)
def test_the_place_of_the_largest_and_what_stands_there(seed: int) -> None:
    seen, running = disturbed(seed, -2.0, 2.0)
    table, known = seen.reshape(6, 10), running.map(lambda part: part.reshape(6, 10))
    row = np.random.default_rng(seed).normal(size=10).astype(np.float32)
    for by_numpy, rule in (
        (np.argmax, choice.place_of_largest),
        (np.argmin, choice.place_of_smallest),
    ):
        places, found = by_numpy(table, axis=1), rule({"axis": 1, "keepdims": 0}, known)
        is_sure = found.error == 0.0
        np.testing.assert_array_equal(places[is_sure], found.value[is_sure])
        assert_holds(row[places], choice.elements({}, exactly(row), found))
        column = rule({"axis": 1, "keepdims": 1}, known)
        there = np.take_along_axis(table, places[:, np.newaxis], 1)
        assert_holds(there, choice.elements_along({"axis": 1}, known, column))


def test_whole_numbers_are_exact_however_large() -> None:
    large, small = exactly(np.array([2**40 + 1])), exactly(np.array([7]))
    assert not running_error.multiply(large, small).error.any()
    assert not choice.remainder({}, running_error.add(large, small), small).error.any()
    as_float = functions.cast({"to": TensorProto.FLOAT}, large)
    assert_holds(np.array([2**40 + 1]).astype(np.float32), as_float)
    assert as_float.error[0] > 0.0


def test_a_float_that_may_be_on_either_side_of_a_whole_number_is_no_sure_one() -> None:
    cast = functions.cast(
        {"to": TensorProto.INT64}, Running(np.array([2.0, 2.5]), np.array([1e-6, 1e-6]))
    )
    assert cast.value.tolist() == [2.0, 2.0]
    assert (cast.error > 0.0).tolist() == [True, False]


def test_what_float32_has_is_not_rounded() -> None:
    one, zero = exactly(np.array([1.0])), exactly(np.array([0.0]))
    third = exactly(np.array([1.0 / 3.0], np.float32))
    assert not running_error.subtract(one, zero).error.any()
    assert not running_error.multiply(third, one).error.any()
    assert running_error.multiply(third, third).error.any()
