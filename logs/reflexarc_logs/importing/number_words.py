"""Words of a text log, read as numbers: an array, and which of the words are no numbers."""

import math
from collections.abc import Sequence
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt

Number: TypeAlias = type[float] | type[int]
"""How the words of a format are written: as decimals or as integers."""


class Numbers(NamedTuple):
    """The values of some words."""

    values: npt.NDArray[np.float64]
    """Shape (words,), little-endian; NaN where the word is no number."""
    unreadable: npt.NDArray[np.bool_]
    """Words that are no numbers, shape (words,)."""


def read_numbers(words: Sequence[bytes], number: Number) -> Numbers:
    """Read every word as Python does, but for digits grouped with underscores.

    Args:
        words: without blanks.
        number: what each word stands for.
    """
    try:
        values = np.fromiter(map(number, words), "<f8", len(words))
    except (ValueError, OverflowError):
        return _read_one_by_one(words, number)
    if has_grouped_digits(words):
        return _read_one_by_one(words, number)
    return Numbers(values, np.zeros(len(words), bool))


def has_grouped_digits(words: Sequence[bytes]) -> bool:
    """Whether a word has underscores, which only Python's own numbers may have."""
    return b"_" in b"".join(words)


def _read_one_by_one(words: Sequence[bytes], number: Number) -> Numbers:
    values = [_value(word, number) for word in words]
    unreadable = np.array([value is None for value in values], bool)
    return Numbers(
        np.array([math.nan if value is None else value for value in values], "<f8"), unreadable
    )


def _value(word: bytes, number: Number) -> float | None:
    """The value of a word; None where it is no number, or larger than any float64."""
    if has_grouped_digits([word]):
        return None
    try:
        return float(number(word))
    except (ValueError, OverflowError):
        return None
