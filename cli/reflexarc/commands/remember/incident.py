"""`reflexarc incident`: makes a test of something that happened in a log."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from reflexarc.terminal.output import console, facts, plain, print_json
from reflexarc_runtime.errors import UsageError

if TYPE_CHECKING:
    from reflexarc_logs.cutting.incident_part import IncidentPart
    from reflexarc_logs.reading.reader import Log

MAX_AROUND_S = 24 * 3600.0


@dataclass(frozen=True)
class IncidentCommand:
    """Cut an incident out of a log, as a test: the least stretch that shows it, with a keyframe.

    Without -o it lists what happened: contacts, guards, stops, overruns, marks. The part is
    replayed at once; with `reflexarc_logs` naming its folder, pytest replays it from then on. Exit
    status 1: it does not replay, or does not show the incident.

    Examples:
      reflexarc incident runs/drive.mcap
      reflexarc incident runs/drive.mcap --first contact -o tests/golden/corner.mcap
      reflexarc incident runs/drive.mcap --at 1812 --around 2s --whole -o tests/golden/odd.mcap
    """

    log: tyro.conf.Positional[Path]
    """The log (MCAP) of `reflexarc run --record`, or the folder of its parts, as one log."""
    at: int | None = None
    """The incident at this tick."""
    first: Literal["contact", "guard", "stop", "overrun", "mark"] | None = None
    """The first one of this kind; by default, the first of all."""
    around: str = "5s"
    """How much to keep before and behind it at most."""
    whole: bool = False
    """Keep all of that, not only what shows the incident."""
    out: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """The part's file; it must not exist."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """List the incidents, or cut one out and answer whether it is a test now."""
        from reflexarc.wiring.whole_recordings import as_one_log
        from reflexarc_logs.cutting.incident_part import choose, cut_incident
        from reflexarc_logs.reading.reader import read_log

        around_s = self._around_s()
        with as_one_log(self.log, self.out) as path:
            log = read_log(path)
            if self.out is None:
                return self._list(log)
            incident = choose(log, self.at, self.first)
            found = cut_incident(log, incident, around_s, self.out, narrow=not self.whole)
        self._tell(found)
        return 0 if found.is_shown and found.report.exit_status == 0 else 1

    def _list(self, log: "Log") -> int:
        from reflexarc_logs.reading.incidents import find_incidents

        wanted = [
            one
            for one in find_incidents(log)
            if self.first in (None, one.kind) and self.at in (None, one.tick)
        ]
        if self.json:
            print_json({"incidents": [asdict(one) for one in wanted]})
            return 0
        for one in wanted:
            console.print(f"tick {one.tick:>7}  {one.kind:<8} {plain(one.words)}", markup=False)
        if not wanted:
            console.print("nothing happened: no contact, guard, stop, overrun or mark")
        return 0

    def _around_s(self) -> float:
        try:
            seconds = float(self.around.removesuffix("s"))
        except ValueError:
            seconds = -1.0
        if not 0.0 <= seconds <= MAX_AROUND_S:
            raise UsageError(f"--around: expected seconds, as 5s, got {self.around[:20]!r}")
        return seconds

    def _tell(self, found: "IncidentPart") -> None:
        span = found.part.span
        if self.json:
            print_json(
                {
                    "incident": asdict(found.incident),
                    "part": found.part.path,
                    "from": span.first,
                    "to": span.end,
                    "messages": found.part.messages,
                    "is_shown": found.is_shown,
                    "replay": found.report.verdict,
                }
            )
            return
        rows: dict[str, object] = {
            "incident": found.note,
            "part": found.part.path,
            "ticks": f"{span.first} to {span.end - 1}, {found.part.messages} messages",
            "replay": found.report.verdict,
        }
        if not found.is_shown:
            rows["but"] = "the part does not show the incident; try --whole"
        if found.part.notes:
            rows["note"] = "; ".join(found.part.notes)
        console.print(facts(rows))
