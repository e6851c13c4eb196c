"""The fields of many protobuf messages as arrays, read by plans."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from google.protobuf.descriptor import FieldDescriptor
from google.protobuf.message import DecodeError
from google.protobuf.message import Message as ProtobufMessage

from reflexarc_logs.diffing.column_cursor import ColumnCursor, Octets, Whole, windows
from reflexarc_logs.diffing.wire_plan import (
    FIXED,
    VARINTS,
    ZIGZAG,
    IsIgnored,
    Plan,
    Step,
    StepKind,
    plan_of,
)

Mask: TypeAlias = npt.NDArray[np.bool_]
Numbers: TypeAlias = npt.NDArray[np.int64] | npt.NDArray[np.float64]

MOST_PLANS = 64
"""So many are known at once."""
_NEW_PLANS = 16
"""So many are made at a time: each costs as much as decoding a few messages."""
_LEAST_ROWS = 4
"""Fewer messages are sooner decoded one by one."""
_PADDING = bytes(64)
"""Whoever reads a message that ends in the middle of a field reads these."""


@dataclass
class WireColumns:
    """The fields of messages, (messages,); of those that are not `known` they say nothing."""

    content: bytes
    known: Mask
    """Whether a message was read."""
    types: dict[str, int] = field(default_factory=dict)
    """Of each field that any of them has, by its path: `FieldDescriptor.TYPE_…`."""
    numbers: dict[str, Numbers] = field(default_factory=dict)
    spans: dict[str, tuple[Whole, Whole]] = field(default_factory=dict)
    """Of texts, bytes and lists: where in the content they begin, and how long they are."""
    present: dict[str, Mask] = field(default_factory=dict)
    """Whether it is there, of a field of which that says something."""

    @property
    def data(self) -> Octets:
        """The content as an array."""
        return np.frombuffer(self.content, np.uint8)

    def fill(self, step: Step, rows: Whole, values: tuple[Numbers, ...]) -> None:
        """Take what was read of a field.

        Args:
            step: the field.
            rows: the messages of which it was read.
            values: its numbers; or where it begins, and how long it is.
        """
        count = len(self.known)
        if step.has_presence:
            self.present.setdefault(step.path, np.zeros(count, np.bool_))[rows] = True
        if len(values) == 1:
            self.types[step.path] = step.type
            if step.path not in self.numbers:
                self.numbers[step.path] = _zeros(count, values[0])
            self.numbers[step.path][rows] = values[0]
        elif values:
            self.types[step.path] = step.type
            nowhere = np.zeros(count, np.int64), np.zeros(count, np.int64)
            for array, some in zip(self.spans.setdefault(step.path, nowhere), values, strict=True):
                array[rows] = some


def _zeros(count: int, like: Numbers) -> Numbers:
    return np.zeros(count, np.float64) if like.dtype.kind == "f" else np.zeros(count, np.int64)


class WireReader:
    """Reads messages of one type, and remembers their plans.

    Args:
        kind: the class of the messages.
        is_ignored: whether nobody compares a field.
    """

    def __init__(self, kind: type[ProtobufMessage], is_ignored: IsIgnored) -> None:
        self._kind, self._is_ignored = kind, is_ignored
        self._plans: list[Plan] = []

    def read(self, payloads: Sequence[bytes]) -> WireColumns:
        """The columns of some messages."""
        sizes = np.fromiter(map(len, payloads), np.int64, len(payloads))
        ends = np.cumsum(sizes)
        content = b"".join([*payloads, _PADDING])
        columns = WireColumns(content, np.zeros(len(payloads), np.bool_))
        reading = _Reading(self._kind, columns, ends - sizes, ends)
        left = np.arange(len(payloads))
        for plan in self._plans:
            left = reading.take(plan, left)
        for _ in range(_NEW_PLANS):
            if len(left) < _LEAST_ROWS:
                break
            plan_or_none = plan_of(payloads[int(left[0])], self._kind, self._is_ignored)
            if plan_or_none is None or plan_or_none in self._plans:
                left = left[1:]
                continue
            self._plans = [*self._plans[1 - MOST_PLANS :], plan_or_none]
            left = reading.take(plan_or_none, left)
        return columns


@dataclass(frozen=True)
class _Reading:
    """Messages whose columns are filled, one plan after the other."""

    kind: type[ProtobufMessage]
    columns: WireColumns
    begins: Whole
    ends: Whole

    def take(self, plan: Plan, left: Whole) -> Whole:
        """Read those messages that have this plan; the others."""
        if not len(left):
            return left
        data = self.columns.data
        cursor = ColumnCursor(data, self.begins[left], self.ends[left])
        found: list[tuple[Step, tuple[Numbers, ...]]] = []
        passed_over: list[tuple[Whole, Whole]] = []
        for step in plan:
            begins = cursor.at.copy()
            found.append((step, _read(cursor, step)))
            if not cursor.good.any():
                return left
            if step.kind is StepKind.PASSED_OVER:
                passed_over.append((begins, cursor.at.copy()))
        cursor.close()
        good = cursor.good
        good &= self._texts_are_plain(cursor, found)
        if not self._can_be_decoded(passed_over, good):
            return left
        rows = left[good]
        self.columns.known[rows] = True
        for step, values in found:
            self.columns.fill(step, rows, tuple(v[good] for v in values))
        return left[~good]

    def _texts_are_plain(
        self, cursor: ColumnCursor, found: Iterable[tuple[Step, tuple[Numbers, ...]]]
    ) -> Mask:
        """Whether each text is of ASCII: of other bytes not all are a text."""
        plain = np.ones(len(cursor.at), np.bool_)
        for step, spans in found:
            if step.type == FieldDescriptor.TYPE_STRING and spans:
                starts, sizes = spans
                for size in np.unique(sizes[sizes > 0]).tolist():
                    rows = np.flatnonzero(sizes == size)
                    plain[rows] &= (windows(self.columns.data, size)[starts[rows]] < 0x80).all(1)
        return plain

    def _can_be_decoded(self, passed_over: list[tuple[Whole, Whole]], good: Mask) -> bool:
        """Whether what nobody looks into is what it should be, in all of them."""
        content = self.columns.content
        places = [
            place
            for begins, ends in passed_over
            for place in zip(begins[good].tolist(), ends[good].tolist(), strict=True)
        ]
        try:  # decoded as one, in which the last one counts: if all of them can be, each can
            self.kind.FromString(b"".join([content[start:end] for start, end in places]))
        except DecodeError:
            return False
        return True


def _read(cursor: ColumnCursor, step: Step) -> tuple[Numbers, ...]:
    """What stands at the cursor, behind its tag."""
    cursor.expect(step.tag)
    match step.kind:
        case StepKind.VARINT:
            return (_number(cursor, step.type),)
        case StepKind.FIXED:
            return (cursor.fixed(FIXED[step.type]),)
        case StepKind.OCTETS:
            return cursor.span()
        case StepKind.LIST:
            starts, sizes = cursor.span()
            cursor.require(sizes % np.dtype(FIXED[step.type]).itemsize == 0)
            return starts, sizes
        case StepKind.OPEN:
            cursor.open()
        case StepKind.CLOSE:
            cursor.close()
        case StepKind.PASSED_OVER:
            cursor.span()
    return ()


def _number(cursor: ColumnCursor, kind: int) -> Whole:
    values = cursor.varint()
    cursor.require(values <= VARINTS[kind])
    return (values >> 1) ^ -(values & 1) if kind in ZIGZAG else values
