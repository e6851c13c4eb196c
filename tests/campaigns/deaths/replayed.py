"""Does everything that was recorded replay, a `.partial` after its recovery?"""

from dataclasses import dataclass, field
from pathlib import Path

from reflexarc_logs.container.unfinished import PARTIAL
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.errors import LogError, ReflexarcError

LARGEST_UNBORN_BYTES = 64 << 10
"""What was killed within its first flush, 0.8 s, holds a head and at most a chunk."""


@dataclass
class Replayed:
    """What became of the logs of one robot."""

    finished: int = 0
    recovered: int = 0
    empty: int = 0
    """Logs that were cut off before their first tick was on the disk."""
    bad: list[str] = field(default_factory=list)


def replayed(folder: Path) -> Replayed:
    """Recover and replay everything."""
    found = Replayed()
    for partial in sorted(folder.glob(f"*{PARTIAL}")):
        found.recovered += _recovered(partial, found)
    for path in log_paths([folder]):
        _replay(path, found)
    found.finished -= found.recovered
    return found


def _recovered(partial: Path, found: Replayed) -> bool:
    size_bytes = partial.stat().st_size
    try:
        return recover(partial, partial.with_suffix("")).path.is_file()
    except ReflexarcError as error:
        found.empty += 1
        if size_bytes > LARGEST_UNBORN_BYTES:
            found.bad.append(f"{partial.name}: {error}")
        return False


def _replay(path: Path, found: Replayed) -> None:
    found.finished += 1
    try:
        if next(read_log(path).ticks(), None) is None:
            found.empty += 1
        elif (report := replay(path)).exit_status:
            found.bad.append(f"{path.name}: {report.verdict}")
    except LogError as error:
        found.bad.append(f"{path.name}: {error}")
