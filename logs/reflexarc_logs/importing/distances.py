"""The distances of the scans of a log, out of the words that give them."""

import itertools
import math
from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_logs.decimals import Words, plain_decimals, ungrouped

_Numbers = npt.NDArray[np.float64]


class Ranges(NamedTuple):
    """The ranges of one line."""

    distances_m: _Numbers
    """Shape (words,); no return is +inf, what says nothing is NaN."""
    unreadable: npt.NDArray[np.bool_]
    """Words that were no number, shape (words,)."""


NO_RANGES = Ranges(np.empty(0), np.empty(0, bool))


class Distances:
    """Reads the distances of one format.

    Args:
        number: float or int, which a word stands for.
        metres: distances of numbers, shape (words,) both.
    """

    def __init__(
        self, number: type[float] | type[int], metres: Callable[[_Numbers], _Numbers]
    ) -> None:
        self._number = number
        self._metres = metres

    def of(self, texts: Sequence[bytes]) -> list[Ranges]:
        """The ranges of every text; an empty one has none."""
        full = [text for text in texts if text]
        if not full:
            return [NO_RANGES] * len(texts)
        found = iter(self._ranges(full))
        return [next(found) if text else NO_RANGES for text in texts]

    def _ranges(self, texts: list[bytes]) -> list[Ranges]:
        words = Words.of(texts)
        numbers, is_plain = plain_decimals(words, points=self._number is float)
        unreadable = np.zeros(len(numbers), bool)
        for index in np.flatnonzero(~is_plain).tolist():
            number = self._unusual(words[index])
            numbers[index] = math.nan if number is None else number
            unreadable[index] = number is None
        distances_m = self._metres(numbers).astype("<f8", copy=False)
        first = words.first.tolist()
        return [
            Ranges(distances_m[begin:end], unreadable[begin:end])
            for begin, end in itertools.pairwise(first)
        ]

    def _unusual(self, word: bytes) -> float | None:
        """A number in any notation; None where the word is none."""
        try:
            return float(self._number(ungrouped(word)))
        except (ValueError, OverflowError):
            return None
