"""Numbers out of words, many at once, against Python's own `split`, `float` and `int`."""

import math
import re

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_logs.decimals import Words, plain_decimals
from reflexarc_logs.importing.distances import Distances, Ranges

TEXTS = st.lists(st.text("0123456789. \t\r\n\v\f\0é", max_size=40).map(str.encode), max_size=5)
NEAR_NUMBERS = st.text("0123456789.0123456789./-+e_,:x\x01?", min_size=1, max_size=10)
DECIMALS = st.from_regex(r"[0-9]{0,8}\.?[0-9]{0,8}", fullmatch=True).filter(lambda w: w.strip("."))
WORDS = st.lists((NEAR_NUMBERS | DECIMALS).map(str.encode), min_size=1, max_size=60)


def ranges_of(number: type[float] | type[int], *texts: bytes) -> list[Ranges]:
    """The numbers themselves, as if they were metres."""
    return Distances(number, lambda numbers: numbers).of(texts)


def read_by_python(number: type[float] | type[int], word: bytes) -> float | None:
    if b"_" in word:
        return None
    try:
        return float(number(word))
    except ValueError:
        return None


@given(TEXTS)
def test_words_are_those_of_split(texts: list[bytes]):
    words = Words.of(texts)
    found = [words[index] for index in range(len(words.starts))]
    assert found == [word for text in texts for word in text.split()]
    counts = np.diff(words.first).tolist()
    assert counts == [len(text.split()) for text in texts]


@given(WORDS)
def test_plain_decimals_are_found_and_are_the_numbers_that_python_reads(texts: list[bytes]):
    for points, pattern in ((True, rb"\d+\.?\d*|\.\d+"), (False, rb"\d+")):
        numbers, is_plain = plain_decimals(Words.of(texts), points=points)
        for text, number, plain in zip(texts, numbers, is_plain, strict=True):
            assert plain == (len(text) <= 8 and re.fullmatch(pattern, text) is not None)
            assert not plain or number == float(text)


@given(WORDS)
def test_every_word_is_the_number_that_python_reads_or_unreadable(words: list[bytes]):
    for number in (float, int):
        (found,) = ranges_of(number, b" ".join(words))
        expected = [read_by_python(number, word) for word in words]
        assert found.unreadable.tolist() == [value is None for value in expected]
        np.testing.assert_array_equal(
            found.distances_m, [math.nan if value is None else value for value in expected]
        )


@given(TEXTS)
def test_every_text_has_its_own_ranges(texts: list[bytes]):
    together = ranges_of(float, *texts)
    for text, found in zip(texts, together, strict=True):
        (alone,) = ranges_of(float, text)
        np.testing.assert_array_equal(found.distances_m, alone.distances_m)


def test_a_number_beyond_all_floats_is_unreadable():
    (found,) = ranges_of(int, b"9" * 400)
    assert found.unreadable.tolist() == [True]
