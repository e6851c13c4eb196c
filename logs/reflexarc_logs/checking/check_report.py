"""What a check of logs found, worst first: as data, as lines."""

import dataclasses
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from reflexarc_logs.checking.findings import LogFinding, Severity


@dataclass(frozen=True)
class SensorCheck:
    """The stream that a log stands on, and its longest silence."""

    topic: str
    period_s: float
    """The usual time from message to message; 0: there is none."""
    longest_silence_s: float

    @property
    def words(self) -> str:
        """As a table shows it."""
        periods = self.longest_silence_s / self.period_s if self.period_s else 0.0
        return f"{self.longest_silence_s:.3f} s" + f", {periods:.1f} periods" * bool(periods)


@dataclass(frozen=True)
class LogCheck:
    """One log, checked."""

    path: str
    is_ours: bool = False
    """Whether reflexarc recorded it; of others neither contract nor replay is looked at."""
    bytes: int = 0
    messages: int = 0
    duration_s: float = 0.0
    ticks: int = 0
    sensor: SensorCheck | None = None
    replay: str = ""
    """The verdict; empty: there is nothing to replay."""
    findings: tuple[LogFinding, ...] = ()
    """Errors first."""
    refusal: str = ""
    """Why it cannot be read at all; else empty."""

    def count(self, severity: Severity) -> int:
        """Its findings of a severity."""
        return sum(finding.severity == severity for finding in self.findings)

    @property
    def verdict(self) -> str:
        """In a few words."""
        if self.refusal:
            return "unreadable"
        counts = [(self.count("error"), "error"), (self.count("warning"), "warning")]
        said = [f"{n} {name}{'s' * (n > 1)}" for n, name in counts if n]
        return ", ".join(said) or "sound"

    @classmethod
    def from_plain(cls, plain: Mapping[str, Any]) -> "LogCheck":
        """What `dataclasses.asdict` made of it, back from JSON."""
        sensor = plain["sensor"]
        return cls(
            **{
                **plain,
                "sensor": None if sensor is None else SensorCheck(**sensor),
                "findings": tuple(LogFinding(**one) for one in plain["findings"]),
            }
        )


@dataclass(frozen=True)
class CheckReport:
    """All logs that were checked."""

    logs: tuple[LogCheck, ...]
    """The worst first."""

    @classmethod
    def of(cls, logs: Iterable[LogCheck]) -> "CheckReport":
        """Sort them: unreadable ones, then by errors, then by warnings, then by path."""
        return cls(tuple(sorted(logs, key=_goodness)))

    @property
    def exit_status(self) -> int:
        """0: all are sound. 1: something was found. 2: a file cannot be read."""
        if any(log.refusal for log in self.logs):
            return 2
        return int(any(log.findings for log in self.logs))

    def as_dict(self) -> dict[str, Any]:
        """Everything, for `--json`."""
        logs = [{"verdict": log.verdict, **dataclasses.asdict(log)} for log in self.logs]
        return {"exit_status": self.exit_status, "logs": logs}

    def lines(self) -> Iterator[str]:
        """What was found, in words, log by log."""
        for log in self.logs:
            if log.refusal:
                yield f"{log.path}: {log.refusal}"
            elif log.findings:
                yield f"{log.path}: {log.verdict}"
                yield from (f"  {f.severity}: {f.kind}: {f.words}" for f in log.findings)


def _goodness(log: LogCheck) -> tuple[bool, int, int, str]:
    return not log.refusal, -log.count("error"), -log.count("warning"), log.path
