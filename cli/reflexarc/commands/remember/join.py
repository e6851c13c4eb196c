"""`reflexarc join`: makes one log of the parts of a recording."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Annotated

import tyro

from reflexarc.terminal.output import console, facts, print_json


@dataclass(frozen=True)
class JoinCommand:
    """Join the parts of a recording to one log, which replays as a whole.

    Which parts there are, and their order, is said by the manifest (NAME.parts.jsonl), not by
    names. Parts of another run, and ticks that stand in two parts, are refused; parts that were
    removed or lost are named. Exit status 1: something is missing, or the whole does not replay.

    Examples:
      reflexarc join runs/patrol -o runs/patrol.mcap
      reflexarc join runs/drive.parts.jsonl -o runs/whole.mcap --json
    """

    place: tyro.conf.Positional[Path]
    """The recording's folder, or its manifest."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """The log to be; it must not exist."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Join, replay the whole, and answer whether nothing is missing and it replays."""
        from reflexarc_logs.cutting.join import join
        from reflexarc_logs.reading.reader import read_log
        from reflexarc_logs.replaying.replay import replay

        found = join(self.place, self.out)
        verdict, status = "not replayed: no policy is attached", int(bool(found.gaps))
        if read_log(found.path).policy is not None:
            report = replay(found.path)
            verdict, status = report.verdict, max(status, report.exit_status)
        if self.json:
            print_json({**asdict(found), "replay": verdict})
            return status
        rows: dict[str, object] = {
            "log": found.path,
            "parts": f"{len(found.parts)}, {found.ticks} ticks, {found.messages} messages",
            "replay": verdict,
        }
        if found.gaps:
            rows["missing"] = "; ".join(found.gaps)
        console.print(facts(rows))
        return status
