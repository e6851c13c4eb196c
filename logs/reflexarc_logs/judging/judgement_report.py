"""What was found about a candidate on all logs, the worst first: as data, as text, as Markdown."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from reflexarc_logs.judging.amounts import amount
from reflexarc_logs.judging.judgement import VERDICTS, LogJudgement
from reflexarc_logs.judging.judgement_text import (
    HEAD,
    SHOWN_INCIDENTS,
    has_details,
    incident_words,
    log_lines,
    markdown_row,
    row,
)
from reflexarc_logs.judging.text_table import aligned, markdown_table, quoted
from reflexarc_runtime.words.shown import plain

SHOWN_LOGS = 8
"""Logs of which more than a row is shown: those that are worst."""
SHOWN_ROWS = 500
"""Rows of the Markdown: a comment takes 65,536 characters."""

OPEN_LOOP = (
    "open loop: the candidate is asked about what another policy saw; its answers moved nothing"
)


@dataclass(frozen=True)
class Judgement:
    """A candidate on all logs."""

    candidate: str
    """The name of its file."""
    policy_hash: str
    limits: tuple[str, ...]
    """What it was judged by, each in words."""
    logs: tuple[LogJudgement, ...]
    """The worst first."""

    @property
    def exit_status(self) -> int:
        """That of the worst log: 2 is worse than 1, as what was not judged may be anything."""
        return max((one.exit_status for one in self.logs), default=2)

    @property
    def verdict(self) -> str:
        """The exit status in words."""
        return VERDICTS[self.exit_status]

    @property
    def ticks(self) -> int:
        """Ticks that count, in all logs."""
        return sum(one.ticks for one in self.logs)

    @property
    def flips(self) -> int:
        """Flips that count, in all logs."""
        return sum(one.flips for one in self.logs)

    @property
    def reversals(self) -> int:
        """Reversals in all logs."""
        return sum(one.reversals for one in self.logs)

    def as_dict(self) -> dict[str, Any]:
        """Everything, for `--json`; retinas in hexadecimal."""
        return {
            "verdict": self.verdict,
            "exit_status": self.exit_status,
            "candidate": self.candidate,
            "policy_hash": self.policy_hash,
            "limits": self.limits,
            "ticks": self.ticks,
            "flips": self.flips,
            "reversals": self.reversals,
            "logs": [_said(one) for one in self.logs],
        }

    def lines(self) -> list[str]:
        """A text for people."""
        return list(_lines(self))

    def markdown(self) -> str:
        """A table with its verdict, for a comment on a change."""
        return "\n".join(_markdown(self))


def worst_first(logs: list[LogJudgement]) -> tuple[LogJudgement, ...]:
    """Sorted: what could not be judged, what is beyond, then by rate, reversals and margin."""
    return tuple(sorted(logs, key=_badness))


def _badness(one: LogJudgement) -> tuple[int, int, float, int, float, str]:
    return (
        -one.exit_status,
        -one.faults,
        -one.rate,
        -one.reversals,
        -one.largest_margin,
        one.log,
    )


def _lines(found: Judgement) -> Iterator[str]:
    logs = amount(len(found.logs), "log")
    yield f"{plain(found.candidate)} ({found.policy_hash[:12]}) on {logs}: {found.verdict}"
    yield f"  {'; '.join(found.limits)}"
    yield f"  {OPEN_LOOP}"
    yield ""
    yield from aligned([HEAD, *map(row, found.logs)])
    for log in [one for one in found.logs if has_details(one)][:SHOWN_LOGS]:
        yield ""
        yield from log_lines(log)


def _markdown(found: Judgement) -> Iterator[str]:
    yield f"**{found.verdict}**: {quoted(plain(found.candidate))} (`{found.policy_hash[:12]}`)"
    yield ""
    yield f"{'; '.join(found.limits)}. {OPEN_LOOP.capitalize()}."
    yield ""
    rows = [markdown_row(one) for one in found.logs[:SHOWN_ROWS]]
    yield from markdown_table([HEAD, *rows])
    if len(found.logs) > SHOWN_ROWS:
        yield ""
        yield f"… and {len(found.logs) - SHOWN_ROWS} logs that are no worse"
    details = [one for one in found.logs if one.incidents][:SHOWN_LOGS]
    for one in details:
        yield ""
        for incident in one.incidents[:SHOWN_INCIDENTS]:
            yield f"- {quoted(plain(one.log))}: {quoted(incident_words(incident, one))}"


def _said(one: LogJudgement) -> dict[str, Any]:
    head = {"log": one.log, "verdict": one.verdict, "exit_status": one.exit_status}
    return {**head, "rate": one.rate, **one.to_plain()}
