"""`reflexarc check`: whether logs are sound, one line a log."""

import os
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import tyro

from reflexarc.terminal.output import console, print_json

if TYPE_CHECKING:
    from reflexarc_logs.checking.check_report import CheckReport


@dataclass(frozen=True)
class CheckCommand:
    """Check logs, ours or not: bytes, completeness, gaps, clocks; of ours also that they replay.

    One line a log, the worst first, then what was found in words. An error: the log is not, or
    does not say, what happened. A warning: it is true, and something in it should be looked at.
    Logs of other systems (bags of ROS 2 in MCAP) have neither contract nor replay. Exit status 0:
    all are sound; 1: something was found; 2: a file cannot be read.

    Examples:
      reflexarc check runs/drive.mcap
      reflexarc check tests/golden runs --jobs 4
      reflexarc check bags --json
    """

    logs: tyro.conf.Positional[tuple[Path, ...]]
    """Logs (MCAP), and folders of logs."""
    jobs: int = 0
    """Processes; 0: one a processor. The report is the same for any number."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Check, print the table, and answer with its exit status."""
        from reflexarc.terminal.late_progress import late_progress
        from reflexarc.wiring.keeping_logs.unfinished_logs import say_what_is_left_out
        from reflexarc_logs.checking.check_logs import check_logs
        from reflexarc_logs.reading.log_paths import log_paths
        from reflexarc_runtime.crew.crew import MOST_JOBS
        from reflexarc_runtime.errors import UsageError

        if not 0 <= self.jobs <= MOST_JOBS:
            raise UsageError(f"--jobs: expected 1 to {MOST_JOBS}, got {self.jobs}")
        paths = log_paths(self.logs)
        say_what_is_left_out("check", self.logs)
        with late_progress("checking", len(paths)) as progress:
            report = check_logs(paths, self.jobs or len(os.sched_getaffinity(0)), progress)
        self._tell(report)
        return report.exit_status

    def _tell(self, report: "CheckReport") -> None:
        if self.json:
            print_json(report.as_dict())
            return
        from reflexarc.terminal.check_table import check_lines

        console.print("\n".join(check_lines(report)), soft_wrap=True)
