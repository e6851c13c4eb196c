"""Ticks that follow each other in a log without anything to say about one of them."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from reflexarc_logs.columns.tick_columns import ColumnReader, TickColumns, Whole
from reflexarc_logs.reading.message_tables import MessageTable, Places
from reflexarc_runtime.arrays import QValues
from reflexarc_runtime.messages_pb2 import Tick

LEAST_TICKS = 4
"""Fewer are sooner decoded one by one."""
_LATEST_NS = 1 << 62


@dataclass(frozen=True)
class TickRun:
    """Ticks of one loop whose numbers follow each other, each OK, with its command behind it."""

    table: MessageTable
    rows: Places
    """Of the ticks in the table, (ticks,)."""
    columns: TickColumns
    """Of all ticks of the table."""
    at: slice
    """Where the run is in them."""

    def __len__(self) -> int:
        return len(self.rows)

    def numbers(self, name: str) -> Whole:
        """index, slot, now_ns, action or winner, (ticks,)."""
        return self.columns.numbers[name][self.at]

    @property
    def first(self) -> int:
        """The index of the first tick."""
        return int(self.numbers("index")[0])

    @property
    def sender(self) -> bytes:
        """Who sent them."""
        return self.table.streams[int(self.table.heads["channel"][self.rows[0]])].sender

    @property
    def arrivals_ns(self) -> Whole:
        """The log times of the ticks, (ticks,)."""
        times: Whole = self.table.heads["log_ns"][self.rows].astype(np.int64)
        return times

    @property
    def retinas(self) -> npt.NDArray[np.uint8]:
        """(ticks, bytes)."""
        return self.columns.retinas[self.at]

    @property
    def q_values(self) -> QValues:
        """(ticks, actions)."""
        return np.ascontiguousarray(self.columns.q_values[self.at]).view("<f4")

    @property
    def states(self) -> npt.NDArray[np.float32]:
        """(ticks, size)."""
        return np.ascontiguousarray(self.columns.states[self.at]).view("<f4")

    def tick(self, place: int) -> Tick:
        """One of them."""
        return Tick.FromString(self.table.payload(int(self.rows[place])))

    def ticks(self) -> Iterator[Tick]:
        """All of them, one by one."""
        return map(self.tick, range(len(self)))


def runs_in(
    reader: ColumnReader, table: MessageTable, rows: Places, is_tick: npt.NDArray[np.bool_]
) -> dict[int, TickRun]:
    """The runs of a table by the place in `rows` at which they begin.

    Args:
        reader: what decodes the ticks.
        table: the messages.
        rows: of the ticks and commands of one robot, in order.
        is_tick: which of them are ticks.
    """
    places = np.flatnonzero(is_tick[:-1] & ~is_tick[1:])
    if not len(places):
        return {}
    ticks, commands = rows[places], rows[places + 1]
    columns = reader.read(table, ticks, commands)
    if columns is None:
        return {}
    usual = columns.usual & _fit(table, ticks, commands)
    follows = usual[1:] & usual[:-1] & (np.diff(places) == 2)
    follows &= np.diff(columns.numbers["index"]) == 1
    channels = table.heads["channel"][ticks]
    follows &= channels[1:] == channels[:-1]
    starts = np.flatnonzero(usual & ~np.concatenate(([False], follows)))
    ends = np.flatnonzero(usual & ~np.concatenate((follows, [False]))) + 1
    return {
        int(places[start]): TickRun(table, ticks[start:end], columns, slice(start, end))
        for start, end in zip(starts.tolist(), ends.tolist(), strict=True)
        if end - start >= LEAST_TICKS
    }


def _fit(table: MessageTable, ticks: Places, commands: Places) -> npt.NDArray[np.bool_]:
    """Whether a tick and its command are of one sender, at a time that can be reckoned with."""
    heads, senders = table.heads, [*{stream.sender for stream in table.streams.values()}]
    whose = np.zeros(max(table.streams) + 1, np.int64)
    for channel, stream in table.streams.items():
        whose[channel] = senders.index(stream.sender)
    channels = heads["channel"]
    alike = whose[channels[ticks]] == whose[channels[commands]]
    fit: npt.NDArray[np.bool_] = alike & (heads["log_ns"][ticks] < _LATEST_NS)
    return fit
