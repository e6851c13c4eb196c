"""Words read together, against Python's own `float` one by one."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.importing.number_words import read_numbers

NEAR_NUMBERS = st.text("0123456789.0123456789./-+e_,:x\x01?", min_size=1, max_size=10)
DECIMALS = st.from_regex(r"[0-9]{0,8}\.?[0-9]{0,8}", fullmatch=True).filter(lambda w: w.strip("."))
INTEGERS = st.from_regex(r"[+-]?[0-9]{1,25}", fullmatch=True)
WORDS = st.lists((NEAR_NUMBERS | DECIMALS | INTEGERS).map(str.encode), max_size=60)


def read_by_python(word: bytes) -> float | None:
    if b"_" in word:
        return None
    try:
        return float(word)
    except ValueError:
        return None


@given(WORDS)
def test_every_word_is_the_number_that_python_reads_or_unreadable(words: list[bytes]):
    values, unreadable = read_numbers(words)
    expected = [read_by_python(word) for word in words]
    assert unreadable.tolist() == [value is None for value in expected]
    np.testing.assert_array_equal(
        values, [math.nan if value is None else value for value in expected]
    )


@pytest.mark.parametrize("word", [b"0x1A", b"1_0", b"1_0.5", b"1,5", b"1.5.", b"--1", b"e3", b"."])
def test_what_is_no_decimal_is_unreadable_and_spoils_no_neighbour(word: bytes):
    values, unreadable = read_numbers([b"7.5", word, b"8e-1"])
    assert unreadable.tolist() == [False, True, False]
    np.testing.assert_array_equal(values, [7.5, math.nan, 0.8])


def test_decimals_that_are_not_finite_are_read_as_what_they_are():
    values, unreadable = read_numbers([b"nan", b"inf", b"-Infinity", b"1e999"])
    assert not unreadable.any()
    np.testing.assert_array_equal(values, [math.nan, math.inf, -math.inf, math.inf])
