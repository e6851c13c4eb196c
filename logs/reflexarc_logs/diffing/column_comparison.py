"""Which fields of thousands of pairs of protobuf messages differ, and by how much, by columns.

It finds what `protobuf_walk` finds of each pair, but for the values: these are decoded of the few
pairs whose values are shown.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import Message as ProtobufMessage

from reflexarc_logs.diffing.column_cursor import Octets, Whole, widened, windows
from reflexarc_logs.diffing.field_values import FieldRules
from reflexarc_logs.diffing.wire_columns import Mask, Numbers, WireColumns, WireReader
from reflexarc_logs.diffing.wire_plan import FIXED

_NO_NUMBERS = (
    FieldDescriptor.TYPE_BOOL,
    FieldDescriptor.TYPE_BYTES,
    FieldDescriptor.TYPE_STRING,
)


@dataclass(frozen=True)
class ColumnDiff:
    """One field, over many pairs."""

    differences: int
    largest: float | None
    """How far two numbers lay apart at most; None: they are no numbers."""
    first: int
    """The first pair in which it differs."""


@dataclass(frozen=True)
class ColumnsFound:
    """What was found of many pairs."""

    unread: list[int]
    """Those that have to be walked one by one; of all others it says everything."""
    identical: int
    fields: dict[str, ColumnDiff]
    """By name."""


class ColumnComparison:
    """Compares messages of one type.

    Args:
        kind: their class.
        rules: what counts.
    """

    def __init__(self, kind: type[ProtobufMessage], rules: FieldRules) -> None:
        self._rules = rules
        self._reader = WireReader(kind, rules.ignored.cover)

    def compare(self, a: Sequence[bytes], b: Sequence[bytes]) -> ColumnsFound:
        """Compare message with message of the same place."""
        sides = self._reader.read(a), self._reader.read(b)
        read = sides[0].known & sides[1].known
        paths = dict.fromkeys([*sides[0].types, *sides[1].types])
        counted = [path for path in paths if not self._rules.ignored.cover(path)]
        read &= self._have_the_same_fields(sides)
        same, fields = read.copy(), dict[str, ColumnDiff]()
        for path in counted:
            found = self._field(path, sides, read)
            if found is not None:
                fields[path], differs = found
                same &= ~differs
        return ColumnsFound(np.flatnonzero(~read).tolist(), int(same.sum()), fields)

    def _have_the_same_fields(self, sides: tuple[WireColumns, WireColumns]) -> Mask:
        """Whether what may be missing is there in both, and lists are equally long."""
        same = np.ones(len(sides[0].known), np.bool_)
        for path in {*sides[0].present, *sides[1].present}:
            if not self._rules.ignored.cover(path):
                ours, theirs = (side.present.get(path, False) for side in sides)
                same &= np.equal(ours, theirs)
        for path in {*sides[0].spans, *sides[1].spans}:
            types = [side.types[path] for side in sides if path in side.types]
            if types[0] in FIXED and not self._rules.ignored.cover(path):
                same &= ~_other_sizes(path, sides)
        return same

    def _field(
        self, path: str, sides: tuple[WireColumns, WireColumns], read: Mask
    ) -> tuple[ColumnDiff, Mask] | None:
        """One field, and in which pairs it differs; None: in none."""
        kind = next(side.types[path] for side in sides if path in side.types)
        counts, apart = np.zeros(len(read), np.int64), np.zeros(len(read))
        if not any(path in side.spans for side in sides):
            numbers = _numbers_of(path, sides)
            rows = np.flatnonzero(_differs(*numbers) & read)
            values = [some[rows, np.newaxis] for some in numbers]
            counts[rows], apart[rows] = self._counting(path, kind, values[0], values[1])
        elif kind in FIXED:
            for rows, x, y in _unequal_octets(path, sides, read):
                ours, theirs = (widened(some.view(FIXED[kind])) for some in (x, y))
                counts[rows], apart[rows] = self._counting(path, kind, ours, theirs)
        else:
            counts[_other_sizes(path, sides) & read] = 1
            for rows, _, _ in _unequal_octets(path, sides, read):
                counts[rows] = 1
        if not counts.any():
            return None
        largest = None if kind in _NO_NUMBERS else float(apart.max())
        found = ColumnDiff(int(counts.sum()), largest, int(np.argmax(counts > 0)))
        return found, counts > 0

    def _counting(
        self, path: str, kind: int, x: Numbers, y: Numbers
    ) -> tuple[Whole, npt.NDArray[np.float64]]:
        """How many values of each pair differ and count, and how far these lie apart at most."""
        counting, apart = _differs(x, y), _apart(x, y)
        for one in self._rules.tolerances if kind not in _NO_NUMBERS else ():
            if one.fields.cover(path):
                with np.errstate(invalid="ignore", over="ignore"):
                    counting &= ~(apart <= one.absolute + one.relative * np.abs(x))
        return counting.sum(1), np.where(counting, apart, 0.0).max(1)


def _numbers_of(path: str, sides: tuple[WireColumns, WireColumns]) -> tuple[Numbers, Numbers]:
    """The numbers of both; of a side that never has the field zeros: it is not written then."""
    known = next(side.numbers[path] for side in sides if path in side.numbers)
    ours, theirs = (side.numbers.get(path, np.zeros_like(known)) for side in sides)
    return ours, theirs


def _differs(x: Numbers, y: Numbers) -> Mask:
    """The rule of `plain_values.is_same` for numbers of one kind."""
    if x.dtype.kind != "f":
        return np.not_equal(x, y)
    alike: Mask = ((x == y) & (np.signbit(x) == np.signbit(y))) | (np.isnan(x) & np.isnan(y))
    return ~alike


def _apart(x: Numbers, y: Numbers) -> npt.NDArray[np.float64]:
    """The rule of `field_values.Unequal.apart`."""
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs(x - y).astype(np.float64)
    apart[np.isnan(apart)] = np.inf
    apart[x == y] = 0.0
    return apart


def _spans_of(path: str, side: WireColumns) -> tuple[Whole, Whole]:
    nothing = np.zeros(len(side.known), np.int64)
    return side.spans.get(path, (nothing, nothing))


def _other_sizes(path: str, sides: tuple[WireColumns, WireColumns]) -> Mask:
    return np.not_equal(_spans_of(path, sides[0])[1], _spans_of(path, sides[1])[1])


def _unequal_octets(
    path: str, sides: tuple[WireColumns, WireColumns], read: Mask
) -> Iterator[tuple[Whole, Octets, Octets]]:
    """Of the pairs of one size whose bytes are not the same: which, and the bytes of both."""
    (starts, sizes), (other_starts, other_sizes) = (_spans_of(path, side) for side in sides)
    alike = read & (sizes == other_sizes)
    for size in np.unique(sizes[alike]).tolist():
        if not size:
            continue
        rows = np.flatnonzero(alike & (sizes == size))
        x = windows(sides[0].data, size)[starts[rows]]
        y = windows(sides[1].data, size)[other_starts[rows]]
        unequal = (x != y).any(1)
        if unequal.any():
            yield rows[unequal], x[unequal], y[unequal]
