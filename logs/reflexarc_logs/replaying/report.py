"""What a replay found, in numbers and in words: levels, commands, and what was not compared."""

import dataclasses
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

SHOWN_FLIPS = 12
SHOWN_TOPICS = 12
"""Names that one line of a report has room for; the JSON has all."""


@dataclass(frozen=True, slots=True)
class Divergence:
    """A field of a tick that is not what was recorded."""

    tick: int
    path: str
    recorded: str
    replayed: str


@dataclass(frozen=True, slots=True)
class Flip:
    """A tick at which another action won."""

    tick: int
    recorded: int
    """Index of the action that was recorded."""
    replayed: int
    margin: float
    """Recorded Q-value of the recorded action, minus that of the replayed one."""
    rounding: bool
    """Whether the margin is within the rounding of two backends; else the behaviour changed."""


@dataclass(frozen=True)
class LevelResult:
    """One level of one replay, in numbers."""

    level: str
    """policy or node; shadow: what a policy said that only watched."""
    ticks: int
    """Ticks in the log."""
    compared: int
    identical: int
    """Equal under the rules."""
    fields_compared: int
    not_compared: tuple[str, ...] = ()
    """Fields that only the log or only this package knows."""
    given: tuple[str, ...] = ()
    """Fields that are taken from the log as they stand: nothing in it tells them a second time."""
    warming_up: int = 0
    """Ticks at which a candidate with a memory was asked, and that do not count yet."""
    first: Divergence | None = None
    flips: tuple[Flip, ...] = ()
    """The first of them; a candidate may flip at every tick of a long log."""
    more_flips: int = 0
    """Those behind `flips`."""
    rounding_flips: int = 0
    """Those among all that are rounding."""
    robot: str = ""
    """Of another robot than the one that the log names; empty: of that one."""


@dataclass(frozen=True)
class CommandsResult:
    """What was recorded on `<robot>/command`, beside the commands in the ticks."""

    robot: str
    recorded: int = 0
    compared: int = 0
    identical: int = 0
    without_tick: int = 0
    """Whose tick is not in the log."""
    of_others: int = 0
    """Sent by somebody who sent no tick."""
    of_watchdog: int = 0
    """That a listener heard of a watchdog, which speaks in the place of a late loop."""
    ticks_without: int = 0
    """Ticks whose command is not in the log."""
    first: Divergence | None = None
    """In the tick → as it was sent."""


@dataclass(frozen=True)
class StreamUse:
    """What became of one topic of the log."""

    topic: str
    schema: str
    messages: int
    use: str
    """`compared`, `input` (it led to what was compared), or `not compared`."""


@dataclass(frozen=True, repr=False)
class ReplayReport:
    """What a replay found."""

    log: str
    policy_hash: str
    same_policy: bool
    recorded_backend: str
    backend: str
    actions: tuple[str, ...]
    levels: tuple[LevelResult, ...]
    notes: tuple[str, ...] = ()
    """What the reader should know: why a level was left out, what was left over."""
    commands: tuple[CommandsResult, ...] = ()
    """One for each robot."""
    streams: tuple[StreamUse, ...] = ()
    """Every topic of the log."""

    @property
    def exit_status(self) -> int:
        """0: all equal under the rules. 1: different. 2: nothing was compared."""
        if any(result.identical < result.compared for result in self._results):
            return 1
        return 0 if any(level.compared for level in self.levels) else 2

    @property
    def verdict(self) -> str:
        """The exit status in a word."""
        return ("identical", "different", "nothing was compared")[self.exit_status]

    def as_dict(self) -> dict[str, Any]:
        """Everything, for `--json`."""
        head = {"verdict": self.verdict, "exit_status": self.exit_status}
        return {**head, **dataclasses.asdict(self)}

    def lines(self) -> list[str]:
        """A text for people, under 40 lines for a log of one robot."""
        return list(self._lines())

    def __str__(self) -> str:
        return "\n".join(self.lines())

    def __repr__(self) -> str:
        """Short enough for the message of a failed assertion: the verdict, and what differs."""
        found = (result.first for result in self._results)
        first = next((f"; {_divergence(at)}" for at in found if at is not None), "")
        return f"<ReplayReport {self.log}: {self.verdict}{first}>"

    @property
    def _results(self) -> tuple[LevelResult | CommandsResult, ...]:
        return (*self.levels, *self.commands)

    def _lines(self) -> Iterator[str]:
        whose = "the recorded one" if self.same_policy else "another one than recorded"
        yield f"{self.log}: {self.verdict}"
        yield f"  policy {self.policy_hash[:12]}, {whose}"
        yield f"  backend {self.backend}, recorded on {self.recorded_backend}"
        for level in self.levels:
            yield from _level_lines(level, () if level.robot else self.actions)
        for commands in self.commands:
            yield from _command_lines(commands, names_robot=len(self.commands) > 1)
        names = [stream.topic for stream in self.streams if stream.use == "not compared"]
        if names:
            yield f"  not compared: {_few(names)}"
        for note in self.notes:
            yield f"  note: {note}"


def _few(names: list[str]) -> str:
    more = len(names) - SHOWN_TOPICS
    return ", ".join(names[:SHOWN_TOPICS]) + (f" and {more} more" if more > 0 else "")


def _divergence(at: Divergence) -> str:
    return f"first divergence: tick {at.tick}, {at.path}: {at.recorded} → {at.replayed}"


def _command_lines(commands: CommandsResult, names_robot: bool) -> Iterator[str]:
    if commands.recorded:
        whose = f" of {commands.robot}" * names_robot
        yield (
            f"  commands{whose}: {commands.recorded} recorded, {commands.compared} compared with "
            f"their ticks, {commands.identical} identical"
        )
    if commands.first is not None:
        yield f"    {_divergence(commands.first)}"


def _level_lines(level: LevelResult, actions: tuple[str, ...]) -> Iterator[str]:
    whose = f" of {level.robot}" if level.robot else ""
    yield (
        f"  level {level.level}{whose}: {level.ticks} ticks, {level.compared} compared, "
        f"{level.identical} identical; {level.fields_compared} fields"
    )
    if level.warming_up:
        yield f"    not counted: {level.warming_up} ticks in which its memory warms up"
    if level.not_compared:
        yield f"    not compared: {', '.join(level.not_compared)}"
    if level.first is not None:
        yield f"    {_divergence(level.first)}"
    yield from _flip_lines(level, actions)


def _flip_lines(level: LevelResult, actions: tuple[str, ...]) -> Iterator[str]:
    count = len(level.flips) + level.more_flips
    if count:
        changed = count - level.rounding_flips
        yield f"    flips: {count} ({level.rounding_flips} rounding, {changed} behaviour change)"
    for flip in level.flips[:SHOWN_FLIPS]:
        yield f"      {_flip_line(flip, actions)}"
    if count > SHOWN_FLIPS:
        yield f"      … and {count - SHOWN_FLIPS} more"


def _flip_line(flip: Flip, actions: tuple[str, ...]) -> str:
    names = [actions[i] if i < len(actions) else str(i) for i in (flip.recorded, flip.replayed)]
    kind = "rounding" if flip.rounding else "behaviour change"
    return f"tick {flip.tick}: {names[0]} → {names[1]}, margin {flip.margin:.3g}: {kind}"
