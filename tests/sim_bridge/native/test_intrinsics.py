"""Keeping what is marked, against boolean indexing; products and sums, against fractions."""

import os
import subprocess
import sys
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_sim_bridge.native.decorators import compiled
from reflexarc_sim_bridge.native.intrinsics import LANES, keep, multiply_add, whole

DTYPES = [np.float32, np.int32, np.uint32]
numbers = st.floats(-1e6, 1e6, allow_subnormal=False)

ON_AN_OLD_PROCESSOR = """
import numpy as np
from reflexarc_sim_bridge.native.decorators import compiled
from reflexarc_sim_bridge.native.intrinsics import keep

@compiled
def kept(values, marks, out):
    return keep(values, marks, 0, out, 0)

marks = np.arange(16) % 3 == 1
out = np.zeros(16, np.float32)
count = kept(np.arange(16, dtype=np.float32), marks, out)
print(*out[:count].astype(int))
"""


@compiled
def keep_all(
    values: npt.NDArray[Any], marks: npt.NDArray[np.bool_], count: int, kept: npt.NDArray[Any]
) -> int:
    """Keep the marked ones of the first `count` values, as every caller does."""
    n = 0
    for first in range(0, count, LANES):
        n = keep(values, marks, first, kept, n)
    return n


@settings(deadline=None)
@given(st.integers(0, 100), st.integers(0, 2**32 - 1), st.sampled_from([0.0, 0.3, 1.0]))
@pytest.mark.parametrize("dtype", DTYPES)
def test_the_marked_ones_are_kept_in_their_order(
    dtype: type[np.generic], count: int, seed: int, share: float
) -> None:
    draws = np.random.default_rng(seed)
    values = draws.integers(0, 1 << 20, count + LANES).astype(dtype)
    marks = draws.random(count + LANES) < share
    marks[count:] = False
    kept = np.zeros(count + LANES, dtype)
    n = keep_all(values, marks, count, kept)
    np.testing.assert_array_equal(kept[:n], values[marks])


def test_it_writes_no_more_than_one_vector_behind_the_kept() -> None:
    kept = np.full(64, -1, np.int32)
    n = keep_all(np.arange(48, dtype=np.int32), np.arange(48) < 20, 32, kept)
    assert n == 20
    assert (kept[n + LANES :] == -1).all()


@pytest.mark.parametrize(("count", "vectors"), [(0, 0), (1, 1), (16, 1), (17, 2), (160, 10)])
def test_whole_vectors_hold_what_there_is(count: int, vectors: int) -> None:
    assert whole(count) == vectors * LANES


def test_a_processor_without_the_instruction_keeps_the_same(tmp_path: Any) -> None:
    environment = os.environ | {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    (tmp_path / "program.py").write_text(ON_AN_OLD_PROCESSOR)
    done = subprocess.run(
        [sys.executable, tmp_path / "program.py"],
        env=environment | {"NUMBA_CACHE_DIR": str(tmp_path)},
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout.split() == ["1", "4", "7", "10", "13"]


@compiled
def of_doubles(a: float, b: float, c: float) -> float:
    return multiply_add(a, b, c)  # type: ignore[no-any-return]  # an intrinsic has no types


@given(numbers, numbers, numbers)
def test_a_product_and_a_sum_are_rounded_once(a: float, b: float, c: float) -> None:
    assert of_doubles(a, b, c) == float(Fraction(a) * Fraction(b) + Fraction(c))


def test_the_product_is_not_rounded_before() -> None:
    almost = 1.0 + 2.0**-30
    assert of_doubles(almost, almost, -1.0 - 2.0**-29) == 2.0**-60


def test_a_product_and_a_sum_keep_single_precision() -> None:
    third = np.float32(1.0 / 3.0)
    exact = Fraction(float(third)) * 3 - 1
    assert of_doubles(third, np.float32(3.0), np.float32(-1.0)) == float(exact)
