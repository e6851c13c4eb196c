"""Reads the same kind of thing from thousands of places at once, each in a message of its own."""

from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

Octets: TypeAlias = npt.NDArray[np.uint8]
Whole: TypeAlias = npt.NDArray[np.int64]

_MOST_LENGTH_BYTES = 4
_MOST_VARINT_BYTES = 9
"""So many hold 63 bits."""


class ColumnCursor:
    """A place in each of many messages; one that met something else goes back to 0.

    Args:
        data: in which they stand, with 64 bytes behind the last.
        begins: where each begins, (messages,).
        ends: where each ends, (messages,).
    """

    def __init__(self, data: Octets, begins: Whole, ends: Whole) -> None:
        self.at = begins.copy()
        self.good = np.ones(len(begins), np.bool_)
        """Which of them met what was expected so far, (messages,)."""
        self._data = data
        self._ends = [ends]

    def require(self, is_met: npt.NDArray[np.bool_]) -> None:
        """Leave those of which this is not true."""
        if not is_met.all():
            self.good &= is_met
            self.at[~self.good] = 0

    def expect(self, octets: bytes) -> None:
        """Step over these bytes."""
        for octet in octets:
            self.require((self._data[self.at] == octet) & (self.at < self._ends[-1]))
            self.at += 1

    def varint(self, most_bytes: int = _MOST_VARINT_BYTES) -> Whole:
        """Read a number of 7 bits a byte, (messages,)."""
        octets = self._data[self.at]
        values: Whole = (octets & 0x7F).astype(np.int64)
        self.at += 1
        going_on = np.flatnonzero(octets & 0x80)
        for place in range(1, most_bytes):
            if not len(going_on):
                break
            octets = self._data[self.at[going_on]]
            values[going_on] |= (octets & 0x7F).astype(np.int64) << (7 * place)
            self.at[going_on] += 1
            going_on = going_on[octets >= 0x80]
        ended = self.at <= self._ends[-1]
        ended[going_on] = False
        self.require(ended)
        return values

    def fixed(self, dtype: str) -> npt.NDArray[Any]:
        """Read a number of a fixed size, (messages,): int64 or float64."""
        size = np.dtype(dtype).itemsize
        values = windows(self._data, size)[self.at].reshape(-1).view(dtype)
        self.at += size
        self.require(self.at <= self._ends[-1])
        return widened(values)

    def span(self) -> tuple[Whole, Whole]:
        """Step over so many bytes as it says; where they begin, and how many, (messages,)."""
        sizes = self.varint(_MOST_LENGTH_BYTES)
        starts = self.at.copy()
        fits = starts + sizes <= self._ends[-1]
        self.require(fits)
        starts, sizes = np.where(self.good, starts, 0), np.where(self.good, sizes, 0)
        self.at += sizes
        return starts, sizes

    def open(self) -> None:
        """Step into a message, which is so long as it says."""
        starts, sizes = self.span()
        self._ends.append(starts + sizes)
        self.at -= sizes

    def close(self) -> None:
        """Step out of a message, of which nothing may be left."""
        self.require(self.at == self._ends.pop())


def windows(data: Octets, size: int) -> Octets:
    """The bytes from any place on, (places, size)."""
    return np.lib.stride_tricks.sliding_window_view(data, size)


def widened(values: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """The same numbers as int64 or float64."""
    with np.errstate(invalid="ignore"):  # a NaN that signals
        return values.astype(np.float64 if values.dtype.kind == "f" else np.int64)
