"""An account of one robot's log: its ticks in their order, its commands, and every other topic.

One pass over the file feeds it and level `policy` alike. What it cannot compare it counts.
"""

from collections import Counter
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt
from google.protobuf.message import DecodeError

from reflexarc_logs.columns.tick_columns import ColumnReader
from reflexarc_logs.columns.tick_runs import TickRun, runs_in
from reflexarc_logs.reading.message_tables import MessageTable, Places
from reflexarc_logs.reading.reader import Log, Record, decode
from reflexarc_logs.replaying.recorded_holds import ASKED_VALUES
from reflexarc_logs.replaying.report import CommandsResult
from reflexarc_logs.replaying.sent_commands import SentCommands
from reflexarc_logs.replaying.serving.served_policies import ServedPolicies
from reflexarc_logs.replaying.tick_order import TickOrder
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages.topics import COMMAND, TICK
from reflexarc_runtime.messages_pb2 import Decision, Tick

MOST_LOOPS = 16
"""Loops whose ticks are followed one by one; more are counted as one."""
_LATEST_NS = 1 << 62


class LogAccount:
    """What stands in a log beside what is compared.

    Args:
        log: as one robot's.
        served: who decides on it; None: nobody but the policy that the log names.
    """

    def __init__(self, log: Log, served: ServedPolicies | None = None) -> None:
        self.log, self.served = log, served
        self.streams: Counter[tuple[str, str]] = Counter()
        """Messages by topic and schema."""
        self.other_policies: Counter[str] = Counter()
        """Ticks that name another policy than the log does, by its hash."""
        self.without_values = 0
        """Ticks whose verdict says that the policy answered, and that hold no answer."""
        self._orders: dict[bytes, TickOrder] = {}
        self._shift_ns = 0
        """How far the arrival of the first tick is from its own time."""
        self._as_shifted = 0
        """Ticks that are as far."""
        self._tick = log.topic(TICK.name)
        self._command = log.topic(COMMAND.name), COMMAND.schema
        self._offset_ns = log.run.wall_offset_ns
        self._reader = ColumnReader(log.run.policy_hash)
        self._commands = SentCommands(log.run.robot, by_loop=log.run.recorded_by == "run")

    @property
    def ticks_seen(self) -> int:
        """Ticks of this robot."""
        return sum(order.ticks for order in self._orders.values())

    def ticks(self) -> Iterator[Tick]:
        """The ticks that the named policy may be asked about, while all is taken into account.

        Raises:
            LogError: the log cannot be read.
        """
        for found in self.runs():
            if isinstance(found, TickRun):
                yield from found.ticks()
            else:
                yield found

    def runs(self) -> Iterator[Tick | TickRun]:
        """The same ticks, many at once where there is nothing to say about one of them.

        Raises:
            LogError: the log cannot be read.
        """
        for table in self.log.tables():
            for channel, messages in table.counted.items():
                topic, schema, _ = table.streams[channel]
                self.streams[topic, schema] += messages
            yield from self._runs_in(table)

    def commands(self) -> CommandsResult:
        """What became of the commands, when all was read."""
        return self._commands.result()

    def why_no_loop(self) -> str:
        """What keeps the ticks from being those of one loop; empty if nothing does."""
        if len(self._orders) > 1:
            return f"it holds the ticks of {len(self._orders)} loops: a merged log"
        if any(order.restarts for order in self._orders.values()):
            return "it holds the ticks of more than one run: a merged log"
        return self._shift()

    def notes(self) -> Iterator[str]:
        """What was not compared, or is not there."""
        for sender, order in self._orders.items():
            whose = f"of the loop {sender.hex()[:12]}: " if len(self._orders) > 1 else ""
            yield from (whose + note for note in order.notes())
        for other, ticks in self.other_policies.most_common(MOST_LOOPS):
            yield f"{ticks} ticks name another policy than the log ({other[:12]}): not compared"
        if self.without_values:
            yield f"{self.without_values} ticks hold no Q-values, though the policy was asked"
        yield from _command_notes(self.commands(), self.ticks_seen)

    def _runs_in(self, table: MessageTable) -> Iterator[Tick | TickRun]:
        rows, is_tick = self._own(table)
        runs = runs_in(self._reader, table, rows, is_tick) if self._is_usual(table) else {}
        at = 0
        while at < len(rows):
            run = runs.get(at)
            if run is not None and self._goes_on(run):
                yield run
                at += 2 * len(run)
                continue
            record, at = table.record(int(rows[at])), at + 1
            if not is_tick[at - 1]:
                self._sent(record)
                continue
            tick = decode(self.log, record, Tick)
            self._saw(tick.decision, record)
            if self._is_of_the_policy(tick.decision):
                yield tick

    def _is_usual(self, table: MessageTable) -> bool:
        """Whether its ticks are ticks, and the log's clock one that can be reckoned with."""
        streams = [table.streams[channel] for channel in table.counted]
        kinds = {stream.schema for stream in streams if stream.topic == self._tick}
        return kinds == {TICK.schema} and 0 <= self._offset_ns < _LATEST_NS

    def _own(self, table: MessageTable) -> tuple[Places, npt.NDArray[np.bool_]]:
        """The rows of this robot's ticks and commands, and which of them are ticks."""
        is_tick = table.channels(lambda stream: stream.topic == self._tick)
        is_command = table.channels(lambda stream: stream[:2] == self._command)
        rows = np.flatnonzero(is_tick | is_command)
        return rows, is_tick[rows]

    def _goes_on(self, run: TickRun) -> bool:
        """Take a run into account, if it goes on where its loop was."""
        order = self._orders.get(run.sender)
        if order is None or not order.saw_run(run.first, len(run)):
            return False
        shifts_ns = run.arrivals_ns - self._offset_ns - run.numbers("now_ns")
        self._as_shifted += int(np.count_nonzero(shifts_ns == self._shift_ns))
        self._commands.told_and_sent(run.sender, len(run))
        return True

    def _saw(self, decision: Decision, record: Record) -> None:
        sender = record.sender
        if sender not in self._orders and len(self._orders) >= MOST_LOOPS:
            sender = next(reversed(self._orders))
        order = self._orders.get(sender)
        if order is None:
            order = self._orders[sender] = TickOrder()
        order.saw(decision)
        if not decision.q_values and decision.verdict in ASKED_VALUES:
            self.without_values += 1
        self._note_shift(record.log_ns - self._offset_ns - decision.now_ns)
        self._commands.told(decision, record.sender)

    def _note_shift(self, shift_ns: int) -> None:
        if not self._as_shifted:
            self._shift_ns = shift_ns
        self._as_shifted += shift_ns == self._shift_ns

    def _shift(self) -> str:
        """A log that is shifted as a whole was rewritten, or merged with the one that it names."""
        is_all = 2 * self._as_shifted > self.ticks_seen
        if not self._shift_ns or not is_all or self.log.run.recorded_by != "run":
            return ""
        return f"its times of arrival are {self._shift_ns} ns off those of the run that it names"

    def _is_of_the_policy(self, decision: Decision) -> bool:
        named, other = self.log.run.policy_hash, decision.policy_hash
        if not named or not other or named == other:
            return True
        if other not in self.other_policies and self.served and self.served.knows(other):
            return True
        self.other_policies[other] += 1
        return False

    def _sent(self, record: Record) -> None:
        try:
            self._commands.sent(record.payload, record.sender, record.sequence)
        except DecodeError:
            raise LogError(
                f"{self.log.path}: {record.topic}: expected {COMMAND.schema}, got something else; "
                "damaged?"
            ) from None


def _command_notes(commands: CommandsResult, ticks: int) -> Iterator[str]:
    if ticks and not commands.recorded:
        yield "no commands were recorded beside the ticks: none was compared"
        return
    if commands.ticks_without:
        yield f"{commands.ticks_without} ticks have no recorded command beside them"
    if commands.without_tick:
        yield f"{commands.without_tick} commands have no tick: not compared"
    if commands.of_others:
        yield f"{commands.of_others} commands of senders who sent no tick: not compared"
    if commands.of_watchdog:
        yield f"{commands.of_watchdog} commands OVERRUN, of a watchdog: not compared"
