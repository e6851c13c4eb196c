"""The fields of many ticks as arrays, one layout after the other."""

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
import numpy.typing as npt
from google.protobuf.message import DecodeError

from reflexarc_logs.columns.tick_layout import Octets, TickLayout, layout_of
from reflexarc_logs.reading.message_tables import MessageTable, Places
from reflexarc_runtime.messages_pb2 import Tick

Whole: TypeAlias = npt.NDArray[np.int64]

MOST_LAYOUTS = 64
"""So many are known at once; ticks of more are decoded one by one."""
_NEW_A_TABLE = 24
"""So many are made for one table: each costs as much as twenty ticks."""

_NUMBERS = ("index", "slot", "now_ns")
_SIGNED = ("action", "winner")
_TIMING = 0x12
"""The tag in front of how punctual a tick was."""
_LONGEST_TIMING = 0x7F
_MOST_32_BITS = (1 << 32) - 1


@dataclass
class TickColumns:
    """The fields of ticks, (ticks,) or (ticks, …); where `usual` is false they say nothing."""

    usual: npt.NDArray[np.bool_]
    """Whether a tick is OK, was asked of the policy, and followed by its own command."""
    numbers: dict[str, Whole]
    """index, slot, now_ns, action, winner."""
    retinas: Octets
    """(ticks, bytes)."""
    q_values: Octets
    """(ticks, 4 · actions): float32."""
    states: Octets
    """(ticks, 4 · size)."""

    @classmethod
    def empty(cls, count: int, first: TickLayout) -> "TickColumns":
        """For so many ticks, of the sizes of this layout's."""
        sizes = [first.size(name) for name in ("retina", "q_values", "state")]
        rows = [np.zeros((count, size), np.uint8) for size in sizes]
        numbers = {name: np.zeros(count, np.int64) for name in (*_NUMBERS, *_SIGNED)}
        return cls(np.zeros(count, np.bool_), numbers, *rows)

    def fits(self, layout: TickLayout) -> bool:
        """Whether ticks of this layout have the same sizes."""
        arrays = {"retina": self.retinas, "q_values": self.q_values, "state": self.states}
        return all(layout.size(name) == rows.shape[1] for name, rows in arrays.items())


@dataclass
class ColumnReader:
    """Reads ticks as columns, and remembers their layouts.

    Args:
        policy_hash: which policy they name; empty: any.
    """

    policy_hash: str
    _known: list[TickLayout] = field(default_factory=list)

    def read(self, table: MessageTable, ticks: Places, commands: Places) -> TickColumns | None:
        """The columns of some ticks; None if none of them is usual.

        Args:
            table: in which they stand.
            ticks: their rows there.
            commands: the row of the command that must be the same as in the tick, for each.
        """
        left = np.arange(len(ticks))
        columns: TickColumns | None = None
        for layout in self._known:
            if not len(left):
                break
            columns = columns or TickColumns.empty(len(ticks), layout)
            left = _Matching(table, ticks, commands, columns).take(layout, left)
        for _ in range(_NEW_A_TABLE):
            if not len(left):
                break
            layout_or_none = layout_of(table.payload(int(ticks[left[0]])), self.policy_hash)
            if layout_or_none is None:
                left = left[1:]
                continue
            self._known = [*self._known[1 - MOST_LAYOUTS :], layout_or_none]
            columns = columns or TickColumns.empty(len(ticks), layout_or_none)
            left = _Matching(table, ticks, commands, columns).take(layout_or_none, left)
        return columns


@dataclass(frozen=True)
class _Matching:
    """Ticks whose columns are filled, one layout after the other."""

    table: MessageTable
    ticks: Places
    commands: Places
    columns: TickColumns

    def take(self, layout: TickLayout, left: Places) -> Places:
        """Fill in those of this layout; the others."""
        table = self.table
        begins, ends = table.payloads[self.ticks[left]], table.ends[self.ticks[left]]
        rows, alike = _rows_of(table.data, begins, ends, layout)
        if rows is None:
            return left
        taken = left[alike]
        if self.columns.fits(layout):
            usual = self._have_their_commands(layout, taken, rows)
            usual &= _are_punctual(table, begins[alike] + layout.end, ends[alike])
            self._fill(layout, taken, rows, usual)
        return left[~alike]

    def _have_their_commands(
        self, layout: TickLayout, taken: Places, rows: Octets
    ) -> npt.NDArray[np.bool_]:
        """Whether the command that follows is that of the tick, byte for byte."""
        span, commands = layout.spans["command"], self.commands[taken]
        begins, size = self.table.payloads[commands], span.end - span.start
        usual: npt.NDArray[np.bool_] = self.table.ends[commands] - begins == size
        at = begins[usual]
        usual[usual] = (_windows(self.table.data, size)[at] == rows[usual, slice(*span)]).all(1)
        return usual

    def _fill(
        self, layout: TickLayout, taken: Places, rows: Octets, usual: npt.NDArray[np.bool_]
    ) -> None:
        columns = self.columns
        for name in (*_NUMBERS, *_SIGNED):
            if name in layout.spans:
                values = _numbers(rows[:, slice(*layout.spans[name])])
                if name in _SIGNED:
                    usual = usual & (values <= _MOST_32_BITS)
                    values = (values >> 1) ^ -(values & 1)
                columns.numbers[name][taken] = values
        arrays = {"retina": columns.retinas, "q_values": columns.q_values, "state": columns.states}
        for name, array in arrays.items():
            if name in layout.spans:
                array[taken] = rows[:, slice(*layout.spans[name])]
        columns.usual[taken] = usual


def _rows_of(
    data: Octets, begins: Places, ends: Places, layout: TickLayout
) -> tuple[Octets | None, npt.NDArray[np.bool_]]:
    """The bytes of the ticks that have this layout, (ticks, bytes), and which these are."""
    alike = ends - begins >= layout.end
    for at in range(min(4, layout.end)):  # how long it is stands here: most others fall out
        if layout.mask[at] == 0xFF:
            alike[alike] = data[begins[alike] + at] == layout.bits[at]
    if not alike.any():
        return None, alike
    rows = _windows(data, layout.end)[begins[alike]]
    same = ((rows & layout.mask) == layout.bits).all(1)
    alike[alike] = same
    return (rows if same.all() else rows[same]), alike


def _are_punctual(table: MessageTable, begins: Places, ends: Places) -> npt.NDArray[np.bool_]:
    """Whether how punctual a tick was follows it, and nothing else."""
    sizes = ends - begins
    usual = (sizes >= 2) & (sizes <= _LONGEST_TIMING + 2)
    usual[usual] = table.data[begins[usual]] == _TIMING
    usual[usual] = table.data[begins[usual] + 1] == sizes[usual] - 2
    usual |= sizes == 0
    places = zip(begins[usual].tolist(), ends[usual].tolist(), strict=True)
    try:  # decoded as one, in which the last one counts: if all of them can be, this can
        Tick.FromString(b"".join([table.content[start:end] for start, end in places]))
    except DecodeError:
        return np.zeros(len(usual), np.bool_)
    return usual


def _windows(data: Octets, size: int) -> Octets:
    """The bytes from any place on, (places, size)."""
    return np.lib.stride_tricks.sliding_window_view(data, size)


def _numbers(rows: Octets) -> Whole:
    """The varints of so many bytes, (ticks, bytes)."""
    values: Whole = (rows[:, 0] & 0x7F).astype(np.int64)
    for at in range(1, rows.shape[1]):
        values |= (rows[:, at] & 0x7F).astype(np.int64) << (7 * at)
    return values
