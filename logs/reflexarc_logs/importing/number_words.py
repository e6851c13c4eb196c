"""Words of a text log, read as numbers: an array, and which of the words are no numbers."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt


class Numbers(NamedTuple):
    """The values of some words."""

    values: npt.NDArray[np.float64]
    """Shape (words,), little-endian; NaN where the word is no number."""
    unreadable: npt.NDArray[np.bool_]
    """Words that are no numbers, shape (words,)."""


def read_numbers(words: Sequence[bytes]) -> Numbers:
    """Read every word as Python's `float` does, but for digits grouped with underscores.

    Args:
        words: without blanks.
    """
    try:
        values = np.fromiter(map(float, words), "<f8", len(words))
    except ValueError:
        return _read_one_by_one(words)
    if has_grouped_digits(words):
        return _read_one_by_one(words)
    return Numbers(values, np.zeros(len(words), bool))


def has_grouped_digits(words: Sequence[bytes]) -> bool:
    """Whether a word has underscores, which only Python's own numbers may have."""
    return b"_" in b"".join(words)


def _read_one_by_one(words: Sequence[bytes]) -> Numbers:
    values = [_value(word) for word in words]
    unreadable = np.array([value is None for value in values], bool)
    return Numbers(
        np.array([math.nan if value is None else value for value in values], "<f8"), unreadable
    )


def _value(word: bytes) -> float | None:
    """The value of a word; None where it is no number."""
    if has_grouped_digits([word]):
        return None
    try:
        return float(word)
    except ValueError:
        return None
