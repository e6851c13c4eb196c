"""Good files, changed at random: each mutation is a function of bytes and a seeded die."""

import random
import re
import struct
from collections.abc import Callable

_LENGTHS = (0, 1, 0x7F, 0xFF, 0xFFFF, 2**31 - 1, 2**32 - 1, 2**62, 2**63 - 1, 2**64 - 1)
_NUMBERS = ("nan", "inf", "-inf", "1e999", "-1", "0", "1e-320", "9" * 400, "0x10", "1e9", "true")
_NUMBER = re.compile(rb"-?\d+(?:\.\d+)?")
_MOST_REPEATED = 1 << 16


def mutated(data: bytes, dice: random.Random, *, is_text: bool) -> bytes:
    """The same bytes after one to three mutations."""
    kinds = _OF_TEXT + _OF_BYTES if is_text else _OF_BYTES
    for _ in range(dice.randint(1, 3)):
        data = dice.choice(kinds)(data or b"\0", dice)
    return data


def _flipped(data: bytes, dice: random.Random) -> bytes:
    changed = bytearray(data)
    for _ in range(dice.choice((1, 1, 2, 8))):
        changed[dice.randrange(len(data))] ^= 1 << dice.randrange(8)
    return bytes(changed)


def _cut(data: bytes, dice: random.Random) -> bytes:
    at = dice.randrange(len(data))
    return dice.choice((data[:at], data[at:]))


def _without_a_piece(data: bytes, dice: random.Random) -> bytes:
    begin, end = _span(data, dice)
    return data[:begin] + data[end:]


def _with_a_run(data: bytes, dice: random.Random) -> bytes:
    at, size = dice.randrange(len(data) + 1), dice.choice((1, 7, 64, 4096, _MOST_REPEATED))
    run = dice.choice((b"\0" * size, b"\xff" * size, dice.randbytes(size), b"[" * size))
    return data[:at] + run + data[at:]


def _with_a_length(data: bytes, dice: random.Random) -> bytes:
    """A number that may say how long something is, in as many bytes as formats use, or a varint."""
    width, number = dice.choice((1, 2, 4, 8)), dice.choice(_LENGTHS)
    said = struct.pack("<Q", number)[:width]
    if dice.random() < 0.3:
        said = b"\xff" * (width + 1) + b"\x01"
    at = dice.randrange(len(data))
    return data[:at] + said + data[at + len(said) :]


def _swapped(data: bytes, dice: random.Random) -> bytes:
    a, b, c = sorted(dice.randrange(len(data) + 1) for _ in range(3))
    return data[:a] + data[b:c] + data[a:b] + data[c:]


def _repeated(data: bytes, dice: random.Random) -> bytes:
    begin, end = _span(data, dice)
    times = min(dice.choice((2, 10, 1000)), 1 + _MOST_REPEATED // max(end - begin, 1))
    return data[:begin] + data[begin:end] * times + data[end:]


def _with_a_number(data: bytes, dice: random.Random) -> bytes:
    """One number of a text is another one, or none."""
    found = list(_NUMBER.finditer(data))
    if not found:
        return _flipped(data, dice)
    place = dice.choice(found)
    return data[: place.start()] + dice.choice(_NUMBERS).encode() + data[place.end() :]


def _with_lines_elsewhere(data: bytes, dice: random.Random) -> bytes:
    lines = data.split(b"\n")
    line = lines.pop(dice.randrange(len(lines)))
    for _ in range(dice.choice((0, 1, 1, 50))):
        lines.insert(dice.randrange(len(lines) + 1), line)
    return b"\n".join(lines)


def _span(data: bytes, dice: random.Random) -> tuple[int, int]:
    begin = dice.randrange(len(data))
    return begin, min(len(data), begin + dice.choice((1, 8, 100, 4000)))


_Mutation = Callable[[bytes, random.Random], bytes]
_OF_BYTES: tuple[_Mutation, ...] = (
    _flipped,
    _cut,
    _without_a_piece,
    _with_a_run,
    _with_a_length,
    _with_a_length,
    _swapped,
    _repeated,
)
_OF_TEXT: tuple[_Mutation, ...] = (_with_a_number,) * 5 + (_with_lines_elsewhere,) * 2
