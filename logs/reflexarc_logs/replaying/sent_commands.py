"""The commands that were recorded on `<robot>/command`, each beside the command in its tick.

A loop's own log has each command right behind its tick. A listener hears them in any order, hears
what a watchdog says in the place of a late loop, and whoever else commands that body.
"""

from dataclasses import replace
from typing import Generic, NamedTuple, TypeVar

from reflexarc_logs.replaying.message_fields import Fields
from reflexarc_logs.replaying.report import CommandsResult, Divergence
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages.wire import NO_SENDER
from reflexarc_runtime.messages_pb2 import Command, Decision

REACH = 4096
"""How far apart in a log a tick and its command may stand, in ticks or commands."""

_FIELDS = Fields(Command.DESCRIPTOR, Command.DESCRIPTOR)  # type: ignore[arg-type]  # one of two stubs
_OVERRUN = Verdict.OVERRUN.value


class _Told(NamedTuple):
    """A command in a tick."""

    sender: bytes
    payload: bytes


class _Sent(NamedTuple):
    """A command on its own."""

    sender: bytes
    command: Command


T = TypeVar("T", _Told, _Sent)


class SentCommands:
    """Compares the commands of one robot while its log is read.

    Args:
        robot: its name.
        by_loop: whether the loop recorded them itself; else a listener did.
    """

    def __init__(self, robot: str, *, by_loop: bool) -> None:
        self._by_loop = by_loop
        self._result = CommandsResult(robot)
        self._recorded = self._alike = 0
        self._newest: tuple[int, _Told] | None = None
        """The last tick, while its command has not come."""
        self._told: _Waiting[_Told] = _Waiting()
        self._sent: _Waiting[_Sent] = _Waiting()
        self._senders: set[bytes] = set()

    def told(self, decision: Decision, sender: bytes) -> None:
        """Take a tick."""
        self._senders.add(sender)
        if self._newest is not None:
            self._settle_tick(*self._newest)
        self._newest = (
            decision.command.sequence,
            _Told(sender, decision.command.SerializeToString()),
        )

    def told_and_sent(self, sender: bytes, count: int) -> None:
        """Take so many ticks, each with its command right behind it, byte for byte."""
        self._senders.add(sender)
        if self._newest is not None:
            self._settle_tick(*self._newest)
            self._newest = None
        self._recorded += count
        self._alike += count

    def sent(self, payload: bytes, sender: bytes, sequence: int) -> None:
        """Take a command with its number in the log: almost always the last tick's, byte for byte.

        Raises:
            DecodeError: it is none.
        """
        self._recorded += 1
        newest = self._newest
        if newest is not None and newest[1].payload == payload and newest[1].sender == sender:
            self._newest = None
            self._alike += 1
        else:
            self._take(payload, sender, sequence)

    def result(self) -> CommandsResult:
        """The counts, when all was read."""
        if self._newest is not None:
            self._settle_tick(*self._newest)
            self._newest = None
        lost = self._told.forget(keep=0)
        for sent in self._sent.forget(keep=0):
            self._leave_out(sent)
        self._add(ticks_without=len(lost), compared=self._alike, identical=self._alike)
        self._add(recorded=self._recorded)
        self._alike = self._recorded = 0
        return self._result

    def _take(self, payload: bytes, sender: bytes, sequence: int) -> None:
        command = Command.FromString(payload)
        newest = self._newest
        numbers = (command.sequence, sequence) if self._by_loop else (command.sequence,)
        if newest is not None and newest[0] in numbers and _same(newest[1].sender, sender):
            if self._is_compared(*newest, command):
                self._newest = None
        elif (told := self._told.pop(command.sequence, sender)) is not None:
            if not self._is_compared(command.sequence, told, command):
                self._told.add(command.sequence, told)
        else:
            self._sent.add(command.sequence, _Sent(sender, command))
            for sent in self._sent.forget(keep=REACH):
                self._leave_out(sent)

    def _settle_tick(self, number: int, told: _Told) -> None:
        """A tick whose command did not follow at once: it came before, or comes later."""
        sent = self._sent.pop(number, told.sender)
        if sent is None or not self._is_compared(number, told, sent.command):
            self._told.add(number, told)
        self._add(ticks_without=len(self._told.forget(keep=REACH)))

    def _is_compared(self, number: int, told: _Told, command: Command) -> bool:
        """Compare; False if the command is none of the loop's."""
        differences = list(_FIELDS.differences(Command.FromString(told.payload), command))
        if differences and not self._by_loop and command.verdict == _OVERRUN:
            self._add(of_watchdog=1)
            return False
        self._add(compared=1, identical=int(not differences))
        if differences and self._result.first is None:
            worst = differences[0]
            first = Divergence(number, f"sent.{worst.path}", worst.recorded, worst.replayed)
            self._result = replace(self._result, first=first)
        return True

    def _leave_out(self, sent: _Sent) -> None:
        if not any(_same(sender, sent.sender) for sender in self._senders):
            self._add(of_others=1)
        elif not self._by_loop and sent.command.verdict == _OVERRUN:
            self._add(of_watchdog=1)
        else:
            self._add(without_tick=1)

    def _add(self, **counts: int) -> None:
        totals = {name: getattr(self._result, name) + more for name, more in counts.items()}
        self._result = replace(self._result, **totals)


class _Waiting(Generic[T]):
    """Ticks that wait for their commands, or the reverse, by number."""

    def __init__(self) -> None:
        self._rows: dict[int, list[T]] = {}
        self._count = 0

    def add(self, number: int, row: T) -> None:
        self._rows.setdefault(number, []).append(row)
        self._count += 1

    def pop(self, number: int, sender: bytes) -> T | None:
        """Take out the first of this number and sender."""
        rows = self._rows.get(number, [])
        for row in rows:
            if _same(row.sender, sender):
                rows.remove(row)
                self._count -= 1
                if not rows:
                    del self._rows[number]
                return row
        return None

    def forget(self, keep: int) -> list[T]:
        """Take out the oldest, but for so many."""
        forgotten: list[T] = []
        while self._count > keep:
            rows = self._rows.pop(next(iter(self._rows)))
            self._count -= len(rows)
            forgotten += rows
        return forgotten


def _same(one: bytes, other: bytes) -> bool:
    """Whether two senders may be one: other tools drop who sent what."""
    return one == other or NO_SENDER in (one, other)
