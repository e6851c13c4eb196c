"""`reflexarc diff`: two logs of anybody, compared topic by topic and field by field."""

from dataclasses import dataclass
from pathlib import Path

import tyro

from reflexarc.terminal.output import console, print_json


@dataclass(frozen=True)
class DiffCommand:
    """Compare two logs, ours or not: what is missing on either side, which fields differ.

    Any two MCAP files; fields of protobuf, JSON and (with the extra `ros2`) of ROS 2 messages,
    everything else as bytes. Messages are paired by their sequence numbers, else by when they were
    sent, else in their order. When they arrived is not compared; of ours, neither is how punctual
    the loop was. Exit status 0: the same under the rules; 1: different; 2: nothing to compare.

    Examples:
      reflexarc diff before.mcap after.mcap
      reflexarc diff before.mcap after.mcap --rules tolerances.toml --markdown
      reflexarc diff bag_0.mcap other_0.mcap --json
    """

    a: tyro.conf.Positional[Path]
    """One log (MCAP)."""
    b: tyro.conf.Positional[Path]
    """The other one."""
    rules: Path | None = None
    """What to ignore, and how far apart values may lie (TOML): see docs/logs.md."""
    markdown: bool = False
    """Print a table for a comment on a change."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Compare, print the report, and answer with its exit status."""
        from reflexarc_logs.diffing.diff import USUAL_RULES, diff
        from reflexarc_logs.diffing.diff_rules import read_rules

        rules = USUAL_RULES if self.rules is None else read_rules(self.rules)
        report = diff(self.a, self.b, rules)
        if self.json:
            print_json(report.as_dict())
        else:
            text = report.markdown() if self.markdown else "\n".join(report.lines())
            console.print(text, soft_wrap=True, markup=False, highlight=False)
        return report.exit_status
