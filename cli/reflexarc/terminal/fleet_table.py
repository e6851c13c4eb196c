"""A fleet as a table: one line for each runtime, as many columns as the terminal has room for."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from rich.cells import cell_len
from rich.console import Group
from rich.table import Table
from rich.text import Text

from reflexarc.terminal.output import microseconds
from reflexarc_runtime.decision import ASKED, Verdict
from reflexarc_runtime.fleet.as_json import shown_id, totals
from reflexarc_runtime.fleet.fleet import MOST_ROBOTS
from reflexarc_runtime.fleet.views import BodyView, FleetView, RobotView, RuntimeView
from reflexarc_runtime.words.shown import plain

NOTHING = "–"
_GAP = 2
_SLOW = 0.98
"""Share of the contract's rate below which a rate is shown as too low."""
_COLOURS = {
    **dict.fromkeys(("OK",), "green"),
    **dict.fromkeys(("GUARDED",), "cyan"),
    **dict.fromkeys(("RECOVERING", "NO_INPUT", "STALE_INPUT"), "yellow"),
    **dict.fromkeys(("STOPPED",), "magenta"),
}
_BAD, _SILENT = "bold red", "bright_black"


@dataclass(frozen=True)
class FleetLine:
    """What one line is about."""

    robot: RobotView
    runtime: RuntimeView | None
    body: BodyView | None

    def is_silent(self, *, of_body: bool) -> bool:
        """Whether the node that a cell is about is heard no more."""
        node = self.body if of_body or self.runtime is None else self.runtime
        return node is not None and node.is_silent


@dataclass(frozen=True)
class FleetColumn:
    """One column."""

    title: str
    cell: Callable[[FleetLine], str | Text]
    worth: int
    """Columns of less worth go first where there is no room."""
    most: int
    """Characters that it takes at most."""
    justify: str = "left"
    of_body: bool = False
    """Whether the body says it, and not the runtime."""


def fleet_screen(fleet: FleetView, width: int, height: int | None, head: str = "") -> Group:
    """The table, cut to a terminal's size, and a line of totals.

    Args:
        fleet: what to show.
        width: columns of the terminal.
        height: its lines; None: there is no end.
        head: shown above all.
    """
    lines = lines_of(fleet)
    room = len(lines) if height is None else max(height - 4 - bool(head), 1)
    shown = lines[: room - 1] if len(lines) > room else lines
    parts: list[Table | Text] = [Text(head, no_wrap=True, overflow="ellipsis")] if head else []
    parts.append(_table(shown, width))
    if len(shown) < len(lines):
        parts.append(Text(f"… and {len(lines) - len(shown)} more: --once shows all", _SILENT))
    parts.append(Text(totals_in_words(fleet), "bold"))
    return Group(*parts)


def lines_of(fleet: FleetView) -> list[FleetLine]:
    """A line for each runtime, and one for each body that has none."""
    return [line for robot in fleet.robots for line in _lines_of_robot(robot)]


def totals_in_words(fleet: FleetView) -> str:
    """All robots together."""
    said = totals(fleet)
    words = [
        _many(said["robots"], "robot"),
        _many(said["runtimes"], "runtime"),
        f"{said['bodies']} {'body' if said['bodies'] == 1 else 'bodies'}",
        f"{said['armed']} armed",
        f"{said['rate_hz']:.0f} ticks/s",
    ]
    words += [f"{said['silent']} silent"] * bool(said["silent"])
    words += [f"{said['unreadable']} messages unreadable"] * bool(said["unreadable"])
    left_out = f"{said['left_out']} left out (room for {MOST_ROBOTS} robots)"
    return " · ".join(words + [left_out] * bool(said["left_out"]))


def _lines_of_robot(robot: RobotView) -> Iterator[FleetLine]:
    runtimes, bodies = robot.runtimes, robot.bodies
    for n in range(max(len(runtimes), len(bodies), 1)):
        runtime = runtimes[n] if n < len(runtimes) else None
        yield FleetLine(robot, runtime, bodies[min(n, len(bodies) - 1)] if bodies else None)


def _table(lines: Sequence[FleetLine], width: int) -> Table:
    cells = {column.title: [_text(column, line) for line in lines] for column in COLUMNS}
    chosen = _fitting(cells, width)
    table = Table(box=None, padding=(0, _GAP, 0, 0), pad_edge=False, header_style="bold")
    for column in chosen:
        needed = _width(column, cells[column.title])
        table.add_column(column.title, justify=column.justify, no_wrap=True, width=needed)  # type: ignore[arg-type]  # one of its words
    for n in range(len(lines)):
        table.add_row(*(cells[column.title][n] for column in chosen))
    return table


def _text(column: FleetColumn, line: FleetLine) -> Text:
    said = column.cell(line)
    text = said if isinstance(said, Text) else Text(plain(said))
    if line.is_silent(of_body=column.of_body):
        text = Text(text.plain, _SILENT)
    text.truncate(column.most, overflow="ellipsis")
    return text


def _fitting(cells: dict[str, list[Text]], width: int) -> list[FleetColumn]:
    """The columns that fit: the most worthy ones, in their order."""
    left, kept = width, set()
    for column in sorted(COLUMNS, key=lambda each: -each.worth):
        needed = _width(column, cells[column.title]) + _GAP
        if needed > left + _GAP:
            break
        left -= needed
        kept.add(column.title)
    return [column for column in COLUMNS if column.title in kept]


def _width(column: FleetColumn, cells: Sequence[Text]) -> int:
    return max([cell_len(column.title), *(cell_len(text.plain) for text in cells)])


def _robot(line: FleetLine) -> str:
    alike = max(len(line.robot.runtimes), len(line.robot.bodies))
    node = line.runtime or line.body
    return f"{line.robot.robot} {shown_id(node.sender)}" if node and alike > 1 else line.robot.robot


def _rate(line: FleetLine) -> str | Text:
    said = line.runtime.said if line.runtime else None
    if said is None or said.rate_hz is None:
        return NOTHING
    due_hz = said.contract_rate_hz
    is_slow = due_hz is not None and said.rate_hz < _SLOW * due_hz
    return Text(f"{said.rate_hz:.1f}", "yellow" if is_slow else "")


def _verdict(line: FleetLine) -> str | Text:
    name = line.runtime.said.verdict if line.runtime else ""
    return Text(name, _COLOURS.get(name, _BAD)) if name else NOTHING


def _share_asked(line: FleetLine) -> str:
    """How many of the last second's ticks were the policy's, in per cent."""
    counts = line.runtime.period_verdicts if line.runtime else None
    if not counts:
        return NOTHING
    asked = sum(count for name, count in counts.items() if name in _ASKED_NAMES)
    return f"{100 * asked / sum(counts.values()):.0f} %"


_ASKED_NAMES = {Verdict(verdict).name for verdict in ASKED}


def _phase(phase: str, percentile: str) -> Callable[[FleetLine], str]:
    def cell(line: FleetLine) -> str:
        spread = line.runtime.said.phases.get(phase) if line.runtime else None
        return NOTHING if spread is None else microseconds(getattr(spread, percentile))

    return cell


def _of_runtime(name: str) -> Callable[[FleetLine], str]:
    def cell(line: FleetLine) -> str:
        return str(getattr(line.runtime.said, name)) or NOTHING if line.runtime else NOTHING

    return cell


def _action(line: FleetLine) -> str:
    if line.runtime is None or not line.runtime.said.verdict:
        return NOTHING
    return line.runtime.said.action or "safe"


def _policy(line: FleetLine) -> str:
    said = line.runtime.said if line.runtime else None
    return (said.policy or said.policy_hash[:12] or NOTHING) if said else NOTHING


def _armed(line: FleetLine) -> str | Text:
    lease = line.body.lease if line.body else None
    if lease is None:
        return NOTHING
    if lease.stopped:
        return Text("stopped", "magenta")
    return Text("armed", "green") if lease.armed else Text("no", "yellow")


def _lease(line: FleetLine) -> str | Text:
    """Whether the body obeys this runtime, another one, or nobody."""
    lease = line.body.lease if line.body else None
    if lease is None:
        return Text("no body", "yellow") if line.body is None else NOTHING
    if line.runtime is not None and line.runtime.sender == lease.holder:
        return "held"
    return Text(f"of {shown_id(lease.holder)}", _BAD) if lease.holder else "free"


def _guard(line: FleetLine) -> str | Text:
    said = line.runtime.said.guard if line.runtime else ""
    if said.startswith("off"):
        return "off"  # as it was asked for; why, --json says
    return Text(said, "" if said == "on" else "yellow") if said else NOTHING


def _recording(line: FleetLine) -> str | Text:
    said = line.runtime.said.recording if line.runtime else ""
    return Text(said, "" if said in ("on", "off") else _BAD) if said else NOTHING


def _watchdog(line: FleetLine) -> str | Text:
    said = line.runtime.said.watchdog if line.runtime else ""
    is_late = line.runtime is not None and line.runtime.said.is_stand_in
    return Text(said, _BAD if is_late else "") if said else NOTHING


def _word(line: FleetLine) -> str:
    """When the runtime, or the body where there is none, was heard last."""
    node = line.runtime or line.body
    return NOTHING if node is None else f"{node.age_s:.1f} s"


COLUMNS = (
    FleetColumn("ROBOT", _robot, 100, 24),
    FleetColumn("HZ", _rate, 95, 7, "right"),
    FleetColumn("VERDICT", _verdict, 99, 13),
    FleetColumn("ASKED", _share_asked, 40, 5, "right"),
    FleetColumn("ACTION", _action, 85, 12),
    FleetColumn("LATE 99 %", _phase("lateness", "p99_ns"), 80, 9, "right"),
    FleetColumn("AGE 50 %", _phase("picture age", "p50_ns"), 75, 9, "right"),
    FleetColumn("99 %", _phase("picture age", "p99_ns"), 30, 9, "right"),
    FleetColumn("SKIPPED", _of_runtime("skipped_slots"), 45, 9, "right"),
    FleetColumn("ARMED", _armed, 90, 7, of_body=True),
    FleetColumn("LEASE", _lease, 70, 11, of_body=True),
    FleetColumn("GUARD", _guard, 55, 16),
    FleetColumn("REC", _recording, 60, 16),
    FleetColumn("POLICY", _policy, 50, 28),
    FleetColumn("SHADOW", _of_runtime("shadow"), 20, 48),
    FleetColumn("PACE", _of_runtime("pace"), 25, 8),
    FleetColumn("WATCHDOG", _watchdog, 15, 26),
    FleetColumn("WORD", _word, 65, 7, "right"),
)
"""In the order in which they are shown."""


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}{'s' * (count != 1)}"
