"""`reflexarc cut`: makes a log of a part of a log."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import tyro

from reflexarc.terminal.output import console, facts, print_json
from reflexarc.wiring.policy_trials import BackendName

if TYPE_CHECKING:
    from reflexarc_logs.cutting.cut import CutReport


@dataclass(frozen=True)
class CutCommand:
    """Cut a part out of a log. It begins with what the controller knew, so it replays by itself.

    Ticks are counted as in the log, from 0; `--from 120 --to 200` keeps ticks 120 to 199. With an
    s, it is seconds since the log's first tick. The part is replayed; exit status 1 if it differs.

    Examples:
      reflexarc cut runs/drive.mcap --from 120 --to 200 -o runs/corner.mcap
      reflexarc cut runs/drive.mcap --from 2.4s --to 8s -o runs/corner.mcap
      reflexarc cut runs/patrol --from 250 --to 420 -o runs/over-two-parts.mcap
    """

    log: tyro.conf.Positional[Path]
    """The log (MCAP); or the folder or manifest of a recording in parts, as one log."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The part's file; it must not exist."""
    since: Annotated[str, tyro.conf.arg(name="from")] = ""
    """First tick, or seconds; by default, the beginning."""
    until: Annotated[str, tyro.conf.arg(name="to")] = ""
    """Tick before which it ends, or seconds; by default, the end."""
    backend: BackendName | None = None
    """What computes the policy for the part's first keyframe; by default what did in the log."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Cut, replay the part, and answer with the replay's exit status."""
        from reflexarc.wiring.whole_recordings import as_one_log
        from reflexarc_logs.cutting.cut import cut
        from reflexarc_logs.cutting.span import span_of
        from reflexarc_logs.reading.reader import read_log
        from reflexarc_logs.replaying.replay import replay

        with as_one_log(self.log, self.out) as path:
            log = read_log(path)
            part = cut(log, span_of(log, self.since, self.until), self.out, self.backend)
            verdict, status = "not replayed: no policy is attached", 0
            if log.policy is not None:
                report = replay(part.path, backend=self.backend)
                verdict, status = report.verdict, report.exit_status
        if self.json:
            print_json({**asdict(part), "replay": verdict})
            return status
        self._tell(part, verdict)
        return status

    def _tell(self, part: "CutReport", verdict: str) -> None:
        rows: dict[str, object] = {
            "part": part.path,
            "ticks": f"{part.span.first} to {part.span.end - 1}, {part.messages} messages",
            "replay": verdict,
        }
        if part.notes:
            rows["note"] = "; ".join(part.notes)
        console.print(facts(rows))
