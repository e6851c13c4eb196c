"""Decimal numbers out of many words at once: up to eight characters are one integer of 64 bits.

A word of digits with at most one point is its digits as an integer, divided by a power of ten. Both
are exact in float64, so the quotient is the float64 nearest to the decimal: the very one that
`float` gives. All other words (a sign, an exponent, nine characters) are left to the caller.

Source of the sums: Daniel Lemire, "Quickly parsing eight digits" (2018), after Wojciech Muła.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

MAX_CHARACTERS = 8

_Integers = npt.NDArray[np.uint64]
_Positions = npt.NDArray[np.int64]
_Mask = npt.NDArray[np.bool_]

_LEAD = bytes(MAX_CHARACTERS) + b" "
"""Before the first word: eight characters can be taken before the end of any."""
_BLANK = 0x20
_TO_BLANKS = bytes(_BLANK if bytes([byte]).isspace() else byte for byte in range(256))


def _integer(value: int) -> np.uint64:
    return np.uint64(value % 2**64)


def _in_every_byte(value: int) -> np.uint64:
    return _integer(value * 0x0101_0101_0101_0101)


_BYTES_IN_USE = np.array([_integer(-1 << 64 - 8 * n) for n in range(MAX_CHARACTERS + 1)])
"""By the length of a word; its last character is the highest byte."""
_NO_POINT = 64
"""Bits before the point where there is none."""
_POWERS_OF_TEN = 10.0 ** np.maximum(7 - np.arange(_NO_POINT + 1) // 8, 0)
"""By the bits before the point."""
_ZEROS = _in_every_byte(ord("0"))
_SIXES, _HIGH_BITS = _in_every_byte(6), _in_every_byte(0xF0)
_POINT, _POINT_BIT = _integer(ord(".") ^ ord("0")), _integer(4)
_POINT_BITS = _in_every_byte(1 << 4)
"""Set in a point less the character zero, and in no digit less that."""
_ONE, _WHOLE_BYTE, _BYTE_BITS = _integer(1), _integer(0xFF), _integer(8)


@dataclass(frozen=True, slots=True)
class Words:
    """The words of some texts, as `bytes.split` finds them."""

    text: bytes
    starts: _Positions
    """In `text`, shape (words,)."""
    ends: _Positions
    first: _Positions
    """The first word of every text, and behind it the count of all words, shape (texts + 1,)."""

    @classmethod
    def of(cls, texts: Sequence[bytes]) -> "Words":
        """Find them."""
        text = (_LEAD + b" ".join([*texts, b""])).translate(_TO_BLANKS)
        blanks = np.flatnonzero(np.frombuffer(text, np.uint8) == _BLANK)
        starts, ends = blanks[:-1] + 1, blanks[1:]
        if not np.all(is_word := starts < ends):  # two blanks side by side
            starts, ends = starts[is_word], ends[is_word]
        begins = np.cumsum([len(_LEAD), *(len(text) + 1 for text in texts)])
        return cls(text, starts, ends, np.searchsorted(starts, begins))

    def __getitem__(self, index: int) -> bytes:
        return self.text[self.starts[index] : self.ends[index]]


def plain_decimals(words: Words, *, points: bool) -> tuple[npt.NDArray[np.float64], _Mask]:
    """The numbers of all words that are plain.

    Args:
        words: of some texts.
        points: whether a number may have one; without them it is an integer.

    Returns:
        Numbers and whether each is one, shape (words,) both; the others have no meaning.
    """
    lengths = words.ends - words.starts
    in_use = _BYTES_IN_USE.take(lengths, mode="clip")
    digits = _last_eight(words) & in_use ^ in_use & _ZEROS
    is_plain = lengths <= MAX_CHARACTERS
    if not points:
        return _value(digits).astype(np.float64), is_plain & (_beyond_nine(digits) == 0)
    digits, bits_before, faults = _without_point(digits)
    is_plain &= (lengths > 1) | (bits_before == _NO_POINT)  # a point alone is no number
    return _value(digits) / _POWERS_OF_TEN.take(bits_before), is_plain & (faults == 0)


def ungrouped(word: bytes) -> bytes:
    """The word, if no digits of it are grouped as only Python's are.

    Raises:
        ValueError: they are.
    """
    if b"_" in word:
        raise ValueError(word)
    return word


def _last_eight(words: Words) -> _Integers:
    """The eight characters before the end of every word, the last one being the highest byte."""
    at_every_byte = np.ndarray((len(words.text) - 7,), "<u8", words.text, 0, (1,))
    return at_every_byte.take(words.ends - MAX_CHARACTERS).astype(np.uint64, copy=False)


def _without_point(digits: _Integers) -> tuple[_Integers, npt.NDArray[np.uint8], _Integers]:
    """What is before the point moved up to what is behind it; without a point nothing changes.

    Returns:
        Digits; how many bits were before the point; what is not zero where a word is no number.
    """
    point = (digits & _POINT_BITS) >> _POINT_BIT  # the lowest bit of its byte
    before_it = point - _ONE  # without a point: all
    digits = digits ^ point * _POINT
    before = digits & before_it
    behind = digits ^ before
    faults = _beyond_nine(digits) | point & before_it | behind & point * _WHOLE_BYTE
    joined = before << (point != 0) * _BYTE_BITS | behind
    return joined, np.bitwise_count(before_it), faults


def _beyond_nine(digits: _Integers) -> _Integers:
    """Not zero where a byte is more than nine."""
    return (digits + _SIXES | digits) & _HIGH_BITS


def _value(digits: _Integers) -> _Integers:
    """The integer of eight digits, the last one being the highest byte."""
    pairs = digits * _integer(10 << 8 | 1) >> _integer(8)
    fours = (pairs & _integer(0x00FF_00FF_00FF_00FF)) * _integer(100 << 16 | 1) >> _integer(16)
    eights = fours & _integer(0x0000_FFFF_0000_FFFF)
    return eights * _integer(10_000 << 32 | 1) >> _integer(32)
