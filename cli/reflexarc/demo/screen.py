"""Shows the results of the demo on one screen."""

from rich.console import Group
from rich.panel import Panel
from rich.table import Table

from reflexarc.demo.results import DemoResult
from reflexarc.terminal.output import kibibytes, microseconds

ScreenRow = tuple[str, str, str]


def screen(found: DemoResult) -> Panel:
    """All results of the demo, for people."""
    table = Table(show_header=False, box=None, padding=(0, 1))
    table.add_column(style="bold cyan", no_wrap=True)
    table.add_column(no_wrap=True)
    table.add_column()
    for section in (_learning, _drive, _log, _lidar, _files):
        for row in section(found):
            table.add_row(*row)
        table.add_section()
    return Panel(Group(table), title="reflexarc: a learned reflex, end to end", expand=False)


def _learning(found: DemoResult) -> list[ScreenRow]:
    learned = found.learning
    return [
        ("learning", "SARSA(λ)", f"{learned.steps:,} steps in {learned.seconds:.1f} s"),
        ("", "contacts / 100 m", "reference field, test worlds"),
        ("", "  never steering", f"{learned.blind_contacts_per_100m:.1f}"),
        ("", "  random", f"{learned.random_contacts_per_100m:.1f}"),
        (
            "",
            "  learned",
            f"{learned.learned_contacts_per_100m:.1f}  "
            f"[{learned.learned_low:.1f} – {learned.learned_high:.1f}], "
            f"{learned.share_of_blind:.2f} of never steering",
        ),
    ]


def _drive(found: DemoResult) -> list[ScreenRow]:
    drive = found.drive
    late = f"p50 {microseconds(drive.lateness_p50_ns)}, p99 {microseconds(drive.lateness_p99_ns)}"
    verdicts = ", ".join(f"{name} {count}" for name, count in drive.verdicts.items())
    return [
        ("drive", "ticks", f"{drive.ticks} at {drive.rate_hz:.2f} Hz"),
        ("", "lateness", late),
        ("", "skipped slots", str(drive.skipped_slots)),
        ("", "verdicts", verdicts),
        ("", "body", f"{drive.distance_m:.1f} m, {drive.contacts} contacts"),
    ]


def _log(found: DemoResult) -> list[ScreenRow]:
    log = found.log
    size = f"{log.messages} messages, {kibibytes(log.bytes)}, {log.seconds:.1f} s"
    rows = [("log", "recorded", size)]
    for name, level in found.replay.levels.items():
        same = f"{level['identical']} of {level['compared']} ticks identical"
        rows.append(("replay", f"level {name}", same))
    return rows


def _lidar(found: DemoResult) -> list[ScreenRow]:
    lidar = found.lidar
    same = ", ".join(f"{count} at level {name}" for name, count in lidar.levels.items())
    return [
        ("lidar", "scans", f"{lidar.scans} ({lidar.source})"),
        ("", "verdict OK", f"{100 * lidar.ok_share:.1f} % of {lidar.ticks} ticks"),
        ("", "replay", f"{lidar.verdict}: {same}"),
    ]


def _files(found: DemoResult) -> list[ScreenRow]:
    return [("made", name, path) for name, path in found.files.items()]
