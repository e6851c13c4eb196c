"""The order of image files, by the numbers in their names.

A name is words and numbers in turns. Numbers are compared as numbers, so that frame2 comes before
frame10; seconds since 1970 with a fraction are one number.
"""

import os
import re
from collections.abc import Iterable
from itertools import pairwise
from pathlib import Path

from reflexarc_runtime.errors import UsageError

Number = tuple[int, str]
"""A whole number and the digits of its fraction, which compare as text."""

_NUMBER = re.compile(r"([0-9]{9,}\.[0-9]+|[0-9]+)")
_LABELLED = re.compile(r"[^\W\d_]{2,}$")
"""Words that give the number behind them a name's part: the 0 of cam0_12."""


def in_order(paths: Iterable[Path]) -> tuple[Path, ...]:
    """Image files in the natural order of their names."""
    return tuple(sorted(paths, key=lambda path: (_key(str(path)), str(path))))


def refuse_several_series(name: str, paths: tuple[Path, ...]) -> None:
    """Refuse files, in their natural order, that would not be shown as they were taken.

    Raises:
        UsageError: two series whose numbers overlap, as of two cameras, or one number twice.
    """
    root = os.path.commonpath([path.parent for path in paths])
    parted = [(path, _parts(path.relative_to(root))) for path in paths]
    numbered = [(path, parts) for path, parts in parted if len(parts) > 1]
    one_series = len({_series(parts) for _, parts in numbered}) == 1
    for (first, before), (second, after) in pairwise(numbered):
        if _place(after, one_series) <= _place(before, one_series):
            raise UsageError(_complaint(name, first, second))


def shown(name: object) -> str:
    """A name in printable signs: files may be named in any bytes."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in str(name))


def _complaint(name: str, first: Path, second: Path) -> str:
    return (
        f"{shown(name)}: expected one series of images, got {shown(first.name)} beside "
        f"{shown(second.name)}; name one series by a glob in quotes, a second eye's by --right"
    )


def _parts(path: Path) -> list[str]:
    """Words and numbers in turns, without the suffix: numbers stand at odd places."""
    return _NUMBER.split(str(path.with_suffix("")).casefold())


def _series(parts: list[str]) -> tuple[str, ...]:
    """What is the same in all names of a series: words, and numbers that belong to a word."""
    numbers = [
        number if len(number) <= 2 and _LABELLED.search(word) else ""
        for word, number in zip(parts[:-2:2], parts[1:-2:2], strict=False)
    ]
    return (*parts[::2], *numbers)


def _place(parts: list[str], one_series: bool) -> tuple[Number, ...]:
    """Where a file stands in its series: all its numbers count, in several only the last."""
    return tuple(map(_number, parts[1::2] if one_series else parts[-2:-1]))


def _number(digits: str) -> Number:
    whole, _, fraction = digits.partition(".")
    return int(whole), fraction


def _key(name: str) -> tuple[str | Number, ...]:
    pieces = enumerate(_NUMBER.split(name.casefold()))
    return tuple(_number(piece) if place % 2 else piece for place, piece in pieces)
