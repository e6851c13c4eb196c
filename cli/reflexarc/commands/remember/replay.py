"""`reflexarc replay`: computes the decisions of logs again, and compares them."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, Protocol

import tyro

from reflexarc.terminal.output import console, plain, print_json, progress_bar
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_logs.judging.flip_limits import FlipLimits
    from reflexarc_logs.judging.log_work import Progress


class TableReport(Protocol):
    """What is said of many logs."""

    @property
    def exit_status(self) -> int:
        """Of the worst log."""
        ...

    def as_dict(self) -> dict[str, Any]:
        """Everything."""
        ...

    def lines(self) -> list[str]:
        """A text for people."""
        ...

    def markdown(self) -> str:
        """A table, for a comment on a change."""
        ...


@dataclass(frozen=True)
class ReplayCommand:
    """Compute the decisions of logs again, without bus and clock, and compare them.

    Level `policy` runs every recorded retina through the policy; level `node` runs every recorded
    message through the controller and compares every field of every decision. By default it does
    both where the log allows it, for every robot in it, and compares each recorded command with its
    tick. What is not compared is said. Exit status 0: all equal; 1: different; 2: nothing to
    compare.

    Several logs, or a folder of them, give one table, the worst log first; the exit status is that
    of the worst log. With `--policy` a candidate is judged on them: how often it prefers another
    action than was preferred (a flip), how often the opposite one (a reversal). Exit status 0: each
    log is within the limits; 1: beyond, and without limits, any flip; 2: a log could not be judged.

    Examples:
      reflexarc replay runs/drive.mcap
      reflexarc replay runs/drive.mcap --policy runs/new/policy.onnx --level policy
      reflexarc replay runs/drive.mcap --json
      reflexarc replay logs/ --policy new.onnx --max-flips 5% --margin 0.02 --jobs 8
      reflexarc replay logs/ --policy new.onnx --max-reversals 0 --from 50s --to 58s --markdown
      reflexarc replay logs/ --policy new.onnx --page judged.html
      reflexarc replay runs/drive.mcap --policy new.onnx --drive --first contact
    """

    logs: tyro.conf.Positional[tuple[Path, ...]]
    """Logs (MCAP) of `reflexarc run --record`, and folders of logs."""
    policy: Path | None = None
    """Decide with this policy; by default, with the one in each log."""
    level: Literal["policy", "node"] | None = None
    """Compare at this level only; a candidate on several logs is judged at level policy."""
    backend: Literal["numpy", "onnxruntime"] | None = None
    """Compute with this; by default, with what the log names."""
    max_flips: str = ""
    """Most flips of a log: a count, or a share of its ticks, as 5%."""
    max_reversals: int | None = None
    """Most flips of a log to the opposite action."""
    margin: float = 0.0
    """Flips whose recorded Q-values lie closer do not count."""
    since: Annotated[str, tyro.conf.arg(name="from")] = ""
    """First tick that counts, or seconds, as 50 or 2.4s; by default, the beginning."""
    until: Annotated[str, tyro.conf.arg(name="to")] = ""
    """Tick before which counting ends, or seconds; by default, the end."""
    jobs: int = 0
    """Processes for several logs; by default as many as there are processors."""
    markdown: bool = False
    """Print a table for a comment on a change."""
    page: Path | None = None
    """Draw what was found about a candidate into this file, a page that needs nothing else."""
    drive: bool = False
    """Rebuild the moments before contacts, and let the candidate drive on."""
    at: int | None = None
    """With --drive: before this tick alone."""
    first: Literal["contact"] | None = None
    """With --drive: before the first contact alone."""
    before: float = 2.0
    """With --drive: how long before it the candidate takes over, seconds."""
    driven: float = 5.0
    """With --drive: how long it drives, seconds."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Replay, print the report, and answer with its exit status."""
        from reflexarc.wiring.keeping_logs.unfinished_logs import say_what_is_left_out
        from reflexarc_logs.judging.flip_limits import FlipLimits
        from reflexarc_logs.reading.log_paths import log_paths

        limits = FlipLimits(self.max_flips, self.max_reversals, self.margin, self.since, self.until)
        paths = log_paths(self.logs)
        say_what_is_left_out("replay", self.logs)
        if limits.are_set and self.policy is None:
            raise UsageError("limits judge a candidate: give one with --policy")
        is_one = len(self.logs) == 1 and not self.logs[0].is_dir()
        if self.drive or self.at is not None or self.first is not None:
            return self._show(self._drive(paths, limits))
        if self.page is not None and self.policy is None:
            raise UsageError("--page: shows what a candidate does; give one with --policy")
        if is_one and not limits.are_set and not self.markdown and self.page is None:
            return self._replay_one(paths[0])
        return self._show(self._table(paths, limits))

    def _replay_one(self, path: Path) -> int:
        from reflexarc_logs.replaying.replay import replay

        report = replay(path, policy=self.policy, level=self.level, backend=self.backend)
        if self.json:
            print_json(report.as_dict())
        else:
            console.print("\n".join(map(plain, report.lines())), soft_wrap=True)
        return report.exit_status

    def _table(self, paths: tuple[Path, ...], limits: "FlipLimits") -> TableReport:
        with progress_bar("logs", len(paths)) as progress:
            if self.policy is None:
                return self._replay_all(paths, progress)
            return self._judge(self.policy, paths, limits, progress)

    def _replay_all(self, paths: tuple[Path, ...], progress: "Progress") -> TableReport:
        from reflexarc_logs.judging.replay_logs import replay_logs

        level, backend = self.level, self.backend
        return replay_logs(paths, level=level, backend=backend, jobs=self.jobs, progress=progress)

    def _judge(
        self, policy: Path, paths: tuple[Path, ...], limits: "FlipLimits", progress: "Progress"
    ) -> TableReport:
        from reflexarc_logs.judging.judge_logs import judge_logs

        if self.level == "node":
            raise UsageError(
                "--level node: a candidate is judged at level policy; replay one log for more"
            )
        found = judge_logs(
            paths, policy, limits, backend=self.backend, jobs=self.jobs, progress=progress
        )
        if self.page is not None:
            from reflexarc_pictures.judgement_page.judged_page import write_judgement_page

            write_judgement_page(found, self.page)
        return found

    def _drive(self, paths: tuple[Path, ...], limits: "FlipLimits") -> TableReport:
        from reflexarc.rebuilding.driven_findings import WantedDrives
        from reflexarc.rebuilding.driven_report import drive_logs

        if not self.drive:
            raise UsageError("--at, --first: say where a candidate drives on; add --drive")
        if limits.are_set or self.level or self.page or self.backend:
            raise UsageError("--drive: takes no limits, --level, --backend or --page")
        wanted = WantedDrives(self.at, self.first is not None, self.before, self.driven)
        with progress_bar("logs", len(paths)) as progress:
            return drive_logs(paths, self.policy, wanted, progress)

    def _show(self, report: TableReport) -> int:
        if self.json:
            print_json(report.as_dict())
        else:
            text = report.markdown() if self.markdown else "\n".join(report.lines())
            console.print(text, soft_wrap=True, markup=False, highlight=False)
        return report.exit_status
