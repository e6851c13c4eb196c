"""`reflexarc import`: lidar logs of other systems, and bags of ROS 2, become MCAP logs."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import tyro

from reflexarc.terminal.output import aside, console, facts, plain, print_json
from reflexarc.wiring.exchange.bag_flags import BagFlags
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.words.suggestion import pasteable

if TYPE_CHECKING:
    from reflexarc_logs.bags.bag_import import BagImport
    from reflexarc_logs.importing.lidar_import import ImportReport

DEFAULT_RATE_HZ = 10.0


@dataclass(frozen=True)
class ImportCommand:
    """Import a log of another system: a bag of ROS 2; CARMEN (Radish), CoreSLAM, plain or gzip.

    The log holds scans, poses and odometry of one laser, as far as the file has them. Malformed
    lines are counted and left out; distances that the sensor could not measure stay unknown.
    Recorded times are kept only on request and only if they grow, because in many logs they do not.

    Of a bag (extra `ros2`) come its LaserScan, Odometry, transforms, and its images beside; its
    times are kept, and what a scanner's driver means is said as for a robot.

    Examples:
      reflexarc import ros2bag runs/bag -o runs/drive.mcap --scan /front/scan
      reflexarc import carmen intel.log.gz -o runs/intel.mcap
      reflexarc import coreslam exp2.dat.gz -o runs/exp2.mcap --rate recorded
    """

    format: tyro.conf.Positional[Literal["carmen", "coreslam", "ros2bag"]]
    """The format of the file."""
    file: tyro.conf.Positional[Path]
    """The log (text, or text in gzip); a bag's folder, or one of its files."""
    out: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Where to write the log (MCAP); it must not exist yet."""
    rate: float | Literal["recorded"] = DEFAULT_RATE_HZ
    """Scans a second, spread evenly from 0; or recorded: the file's own times."""
    bag: BagFlags = field(default_factory=BagFlags)
    robot: str = "robot0"
    """Name of the robot, the first part of every topic."""
    json: bool = False
    """Print one JSON object."""

    def run(self) -> int:
        """Import, and say what was in the file and what was not."""
        from reflexarc_logs.importing.lidar_import import import_log
        from reflexarc_runtime.bus_config import BusConfig

        BusConfig(self.robot)  # refuses a name that cannot be part of a key
        if self.format == "ros2bag":
            return self._import_bag()
        if self.bag != BagFlags():
            raise UsageError(f"{self.format}: what a bag's scanner means is for ros2bag only")
        imported = import_log(self.file, self.out, self.format, rate=self.rate, robot=self.robot)
        if self.json:
            print_json(imported)
            return 0
        console.print(facts(_rows(imported)))
        for note in imported.notes:
            aside.print(f"note: {note}")
        aside.print(f"try: {pasteable('reflexarc', 'play', self.out)}", soft_wrap=True)
        return 0

    def _import_bag(self) -> int:
        from reflexarc_logs.bags.bag_import import import_bag

        if self.rate != DEFAULT_RATE_HZ:
            raise UsageError("--rate: a bag keeps its own times")
        imported = import_bag(self.file, self.out, self.bag.wishes(self.robot))
        if self.json:
            print_json(imported)
            return 0
        console.print(facts(_bag_rows(imported)))
        aside.print(f"try: {pasteable('reflexarc', 'info', self.out)}", soft_wrap=True)
        return 0


def _bag_rows(imported: "BagImport") -> dict[str, object]:
    became = {topic: source for source, topic in imported.became.items()}
    streams = [
        f"{became[topic]} → {topic}: {count}" if topic in became else f"{topic}: {count}"
        for topic, count in imported.messages.items()
    ]
    return {
        "written": f"{imported.log}, {imported.seconds:.1f} s",
        "messages": "\n".join(map(plain, streams)),
        "unusable": plain(_counts(imported.unusable)),
        "left out": plain(", ".join(f"{t} {n}" for t, n in imported.left_out.items())) or "none",
    }


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
