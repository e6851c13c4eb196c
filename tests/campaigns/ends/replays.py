"""Does the log of every runtime replay, however it ended?"""

from dataclasses import dataclass
from pathlib import Path

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import ReflexarcError


@dataclass(frozen=True)
class Replayed:
    """What became of one log."""

    log: str
    was_recovered: bool
    complaint: str
    """Why it does not replay; empty: it does, at both levels."""
    is_empty: bool = False
    """Whether it has no tick: what a recording is killed in its first second may leave."""


def replayed(log: str) -> Replayed:
    """Recover a log if its runtime could not finish it, and replay it."""
    path = Path(log)
    partial = path.with_name(path.name + ".partial")
    try:
        if path.exists() == partial.exists():
            return Replayed(log, False, f"{path.name}: expected the log or its .partial")
        if partial.exists():
            recover(partial, path)
        if not any(True for _ in read_log(path).ticks()):
            return Replayed(log, partial.exists(), f"{path}: no tick", is_empty=True)
        return Replayed(log, partial.exists(), _complaint(path))
    except ReflexarcError as error:
        return Replayed(log, partial.exists(), str(error))


def _complaint(log: Path) -> str:
    report = replay(log)
    levels = {result.level for result in report.levels}
    if levels != {"policy", "node"}:
        return f"{log}: replays only at {', '.join(sorted(levels))}: {'; '.join(report.notes)}"
    return "" if report.exit_status == 0 else f"{log}: replay differs"
