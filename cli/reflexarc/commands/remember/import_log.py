"""`reflexarc import`: lidar logs of other systems become MCAP logs."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from reflexarc.terminal.output import aside, console, facts, print_json
from reflexarc_runtime.words.suggestion import pasteable

if TYPE_CHECKING:
    from reflexarc_logs.importing.lidar_import import ImportReport


@dataclass(frozen=True)
class ImportCommand:
    """Import a lidar log of another system: CARMEN (Radish) or CoreSLAM, plain or gzip.

    The log holds scans, poses and odometry of one laser, as far as the file has them. Malformed
    lines are counted and left out; distances that the sensor could not measure stay unknown.
    Recorded times are kept only on request and only if they grow, because in many logs they do not.

    Examples:
      reflexarc import carmen intel.log.gz -o runs/intel.mcap
      reflexarc import coreslam exp2.dat.gz -o runs/exp2.mcap --rate recorded
    """

    format: tyro.conf.Positional[Literal["carmen", "coreslam"]]
    """The format of the file."""
    file: tyro.conf.Positional[Path]
    """The log (text, or text in gzip)."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Where to write the log (MCAP); it must not exist yet."""
    rate: float | Literal["recorded"] = 10.0
    """Scans a second, spread evenly from 0; or recorded: the file's own times."""
    robot: str = "robot0"
    """Name of the robot, the first part of every topic."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Import, and say what was in the file and what was not."""
        from reflexarc_logs.importing.lidar_import import import_log
        from reflexarc_runtime.bus_config import BusConfig

        BusConfig(self.robot)  # refuses a name that cannot be part of a key
        imported = import_log(self.file, self.out, self.format, rate=self.rate, robot=self.robot)
        if self.json:
            print_json(imported)
            return 0
        console.print(facts(_rows(imported)))
        for note in imported.notes:
            aside.print(f"note: {note}")
        aside.print(f"try: {pasteable('reflexarc', 'play', self.out)}", soft_wrap=True)
        return 0


def _rows(imported: "ImportReport") -> dict[str, object]:
    rate = f"{imported.rate_hz:g} Hz" if imported.rate_hz else "the file's own times"
    broken = _counts(imported.broken_lines)
    if imported.first_broken_line is not None:
        broken += f" (the first one is line {imported.first_broken_line})"
    return {
        "written": imported.log,
        "scans": f"{imported.scans} in {imported.seconds:.1f} s, {rate}",
        "poses": imported.poses,
        "odometry": imported.odometry,
        "beams": f"{imported.beams}, {imported.no_return} without return",
        "unknown beams": _counts(imported.unknown),
        "broken lines": broken,
        "times left out": imported.times_left_out,
        "passed over": _counts(imported.passed_over),
    }


def _counts(kinds: dict[str, int]) -> str:
    return ", ".join(f"{count} {kind}" for kind, count in kinds.items()) or "none"
