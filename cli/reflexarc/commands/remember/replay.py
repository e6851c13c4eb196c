"""`reflexarc replay`: computes the decisions of a log again, and compares them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import tyro

from reflexarc.terminal.output import console, plain, print_json


@dataclass(frozen=True)
class ReplayCommand:
    """Compute the decisions of a log again, without bus and clock, and compare them.

    Level `policy` runs every recorded retina through the policy; level `node` runs every recorded
    message through the controller and compares every field of every decision. By default it does
    both where the log allows it, for every robot in it, and compares each recorded command with its
    tick. What is not compared is said. Exit status 0: all equal; 1: different; 2: nothing to
    compare.

    Examples:
      reflexarc replay runs/drive.mcap
      reflexarc replay runs/drive.mcap --policy runs/new/policy.onnx --level policy
      reflexarc replay runs/drive.mcap --json
    """

    log: tyro.conf.Positional[Path]
    """The log (MCAP) of `reflexarc run --record`."""
    policy: Path | None = None
    """Decide with this policy; by default, with the one in the log."""
    level: Literal["policy", "node"] | None = None
    """Compare at this level only."""
    backend: Literal["numpy", "onnxruntime"] | None = None
    """Compute with this; by default, with what the log names."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Replay, print the report, and answer with its exit status."""
        from reflexarc_logs.replaying.replay import replay

        report = replay(self.log, policy=self.policy, level=self.level, backend=self.backend)
        if self.json:
            print_json(report.as_dict())
        else:
            console.print("\n".join(map(plain, report.lines())), soft_wrap=True)
        return report.exit_status
