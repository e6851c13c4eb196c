"""The report of a campaign as a table, and what failed below it."""

from collections.abc import Mapping, Sequence
from typing import Any

_SHOWN = 10


def failure_table(report: Mapping[str, Any], failures: Sequence[str]) -> str:
    """The report for a person, as Markdown.

    Args:
        report: figure by name; a dictionary is shown in words.
        failures: the names under which a list says what failed: it is counted, and told below.
    """
    lines = ["| | |", "|---|---|"]
    for name, value in report.items():
        shown = len(value) if name in failures else value
        if isinstance(shown, dict):
            shown = ", ".join(f"{key} {count}" for key, count in shown.items())
        lines.append(f"| {name} | {shown} |")
    lines += [f"FAILED {name}: {what}" for name in failures for what in report[name][:_SHOWN]]
    return "\n".join(lines)
