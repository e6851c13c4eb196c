"""Many logs replayed by this software with the policies that they carry: one row each, worst first.

The report's bytes depend on the logs and the software only, as those of `judge_logs`.
"""

import sys
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, cast

from reflexarc_logs.judging.amounts import amount
from reflexarc_logs.judging.log_names import named, without_place
from reflexarc_logs.judging.log_work import (
    LogFailedError,
    Progress,
    job_count,
    share_work,
    sizes_first,
)
from reflexarc_logs.judging.text_table import aligned, markdown_table, quoted
from reflexarc_logs.replaying.replay import replay
from reflexarc_logs.replaying.report import ReplayReport
from reflexarc_logs.replaying.robot_replay import Level
from reflexarc_runtime.crew.worker import serve
from reflexarc_runtime.policy.policy import Backend
from reflexarc_runtime.words.shown import plain

_HEAD = ("log", "ticks", "compared", "identical", "flips", "verdict")
_ITSELF = "reflexarc_logs.judging.replay_logs"
VERDICTS = ("identical", "different", "nothing was compared")


@dataclass(frozen=True)
class ReplayedLog:
    """What the replay of one log found."""

    log: str
    """Its name: the path below the folder that all logs have in common."""
    exit_status: int
    ticks: int = 0
    compared: int = 0
    """Ticks at level `policy`, and those at level `node`."""
    identical: int = 0
    flips: int = 0
    said: str = ""
    """What differs first, or why nothing was compared."""
    notes: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """The exit status in words."""
        return VERDICTS[self.exit_status]


@dataclass(frozen=True)
class ReplayedLogs:
    """What the replay of many logs found."""

    logs: tuple[ReplayedLog, ...]
    """The worst first."""

    @property
    def exit_status(self) -> int:
        """That of the worst log: 2 is worse than 1, as what was not compared may be anything."""
        return max((one.exit_status for one in self.logs), default=2)

    @property
    def verdict(self) -> str:
        """The exit status in words."""
        return VERDICTS[self.exit_status]

    def as_dict(self) -> dict[str, Any]:
        """Everything, for `--json`."""
        head = {"verdict": self.verdict, "exit_status": self.exit_status}
        return {**head, "logs": [{"verdict": one.verdict, **asdict(one)} for one in self.logs]}

    def lines(self) -> list[str]:
        """A text for people."""
        notes = [f"{plain(one.log)}: note: {plain(n)}" for one in self.logs for n in one.notes]
        rows = [_HEAD, *map(_row, self.logs)]
        return [f"{self._title}: {self.verdict}", "", *aligned(rows), *([""] * bool(notes)), *notes]

    def markdown(self) -> str:
        """A table, for a comment on a change."""
        head = f"**{self.verdict}**: {self._title}"
        return "\n".join([head, "", *markdown_table([_HEAD, *map(_markdown_row, self.logs)])])

    @property
    def _title(self) -> str:
        return f"{amount(len(self.logs), 'log')}, replayed by this software"


def replay_logs(
    paths: Iterable[Path],
    *,
    level: Level | None = None,
    backend: Backend | str | None = None,
    jobs: int = 1,
    progress: Progress = lambda done, of: None,
) -> ReplayedLogs:
    """Replay logs, each with the policy that it carries.

    Args:
        paths: of the logs; see `reading.log_paths`.
        level: policy or node; all that each log supports if None.
        backend: what shall compute; as each log names if None.
        jobs: processes; 0: one for each processor.
        progress: called with the logs done and the logs in all.

    Raises:
        UsageError: a number of processes that is none.
    """
    places = named(paths)
    how = {"level": level, "backend": None if backend is None else Backend(backend).value}
    tasks = {name: {"log": str(places[name]), **how} for name in sizes_first(places)}
    answers = share_work(_ITSELF, replay_plain, tasks, job_count(jobs), progress)
    found = [_replayed(name, answers[name], places[name]) for name in places]
    return ReplayedLogs(tuple(sorted(found, key=_badness)))


def replay_plain(given: dict[str, Any]) -> dict[str, Any]:
    """Replay one log.

    Raises:
        LogError: it cannot be read, or does not support the level.
        PolicyError, ContractError: its policy is not intact.
    """
    level = cast("Level | None", given["level"])
    report = replay(Path(given["log"]), level=level, backend=given["backend"])
    return {
        "exit_status": report.exit_status,
        "ticks": max((level.ticks for level in report.levels), default=0),
        "compared": sum(level.compared for level in report.levels),
        "identical": sum(level.identical for level in report.levels),
        "flips": max((len(one.flips) + one.more_flips for one in report.levels), default=0),
        "said": _first(report),
        "notes": list(report.notes),
    }


def main() -> None:
    """Replay logs until the input ends."""
    serve(_do, "logs to replay")


def _do(given: dict[str, Any]) -> dict[str, Any]:
    """Replay one log; `path` are the places where the parent finds modules."""
    sys.path += [place for place in given["path"] if place not in sys.path]
    return replay_plain(given)


def _first(report: ReplayReport) -> str:
    firsts = [level.first for level in report.levels]
    firsts += [commands.first for commands in report.commands]
    found = next((first for first in firsts if first is not None), None)
    if found is None:
        return ""
    return f"first at tick {found.tick}, {found.path}: {found.recorded} → {found.replayed}"


def _replayed(name: str, answer: dict[str, Any] | LogFailedError, path: Path) -> ReplayedLog:
    if isinstance(answer, LogFailedError):
        return ReplayedLog(name, 2, said=without_place(str(answer), path))
    return ReplayedLog(name, **{**answer, "notes": tuple(answer["notes"])})


def _badness(one: ReplayedLog) -> tuple[int, float, int, str]:
    different = one.compared - one.identical
    return -one.exit_status, -different / max(1, one.compared), -different, one.log


def _row(one: ReplayedLog) -> tuple[str, ...]:
    counts = map(str, (one.ticks, one.compared, one.identical, one.flips))
    said = f": {plain(one.said)}" if one.said else ""
    return (plain(one.log), *counts, f"{one.verdict}{said}")


def _markdown_row(one: ReplayedLog) -> tuple[str, ...]:
    """A row in which words of others are code: they may be anything."""
    name, *numbers, _ = _row(one)
    said = f": {quoted(plain(one.said))}" if one.said else ""
    return (quoted(name), *numbers, f"{one.verdict}{said}")


if __name__ == "__main__":
    main()
