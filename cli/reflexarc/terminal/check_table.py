"""The table of `reflexarc check`: one line a log, however narrow the terminal is."""

from collections.abc import Iterator

from reflexarc.terminal.output import plain
from reflexarc_logs.checking.check_report import CheckReport, LogCheck

_HEAD = ("verdict", "messages", "length", "longest silence", "replay", "log")


def check_lines(report: CheckReport) -> Iterator[str]:
    """A table of all logs, the worst first, then what was found in each, in words."""
    rows = [_HEAD, *map(_cells, report.logs)]
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for *cells, path in rows:
        yield "  ".join([*(c.ljust(w) for c, w in zip(cells, widths, strict=False)), path])
    yield from map(plain, report.lines())


def _cells(log: LogCheck) -> tuple[str, ...]:
    name = plain(log.path)
    if log.refusal:
        return log.verdict, "", "", "", "", name
    silence = "" if log.sensor is None else log.sensor.words
    return log.verdict, str(log.messages), f"{log.duration_s:.1f} s", silence, log.replay, name
