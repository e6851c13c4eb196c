"""Lidar logs of other systems."""

import json
import math
from dataclasses import dataclass
from typing import Any

from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from cases.case import Case, Outcome, Said, Stage, Trial
from reflexarc_logs.reading.reader import read_log


@dataclass(frozen=True)
class Imported:
    """What an import said, and what is in the log that it wrote."""

    said: Said
    report: dict[str, Any]
    scans: list[LaserScan]
    poses: list[PoseInFrame]
    odometry: list[PoseInFrame]

    @property
    def seen(self) -> str:
        """In a few words."""
        if not self.scans:
            return f"status {self.said.status}: {self.said.everything.strip()[-160:]}"
        return (
            f"{len(self.scans)} scans of {len(self.scans[0].ranges)} beams, {self.angles}, "
            f"{len(self.poses)} poses, {len(self.odometry)} odometry; "
            f"{self.report['broken_lines'] or 'no'} broken lines; {self.report['notes']}"
        )

    @property
    def angles(self) -> tuple[float, float]:
        """Degrees of the first scan's edges."""
        edges = (self.scans[0].start_angle, self.scans[0].end_angle)
        return round(math.degrees(edges[0]), 3), round(math.degrees(edges[1]), 3)

    def has(self, scans: int, beams: int, right: float, left: float) -> bool:
        """Whether these are the scans, to a thousandth of a degree."""
        found = (len(self.scans), *{len(scan.ranges) for scan in self.scans})
        return found == (scans, beams) and all(
            abs(edge - expected) < 1e-3
            for edge, expected in zip(self.angles, (right, left), strict=True)
        )


def imported(stage: Stage, kind: str, name: str) -> Imported:
    """Import one file of the case."""
    out = stage.scratch / f"{name}.mcap"
    said = stage.reflexarc("import", kind, stage.inputs / name, "-o", out, "--json")
    if said.status or not out.is_file():
        return Imported(said, {}, [], [], [])
    log = read_log(out)
    poses = (log.messages(f"/robot0/{topic}", PoseInFrame) for topic in ("pose", "odometry"))
    return Imported(
        said,
        json.loads(said.out),
        [scan for _, scan in log.messages("/robot0/scan", LaserScan)],
        *([pose for _, pose in stream] for stream in poses),
    )


def _present(name: str) -> Trial:
    def tried(stage: Stage) -> Outcome:
        got = imported(stage, "carmen", name)
        ahead_m = {round(scan.pose.position.x, 4) for scan in got.scans}
        holds = got.has(20, 181, -90, 90) and len(got.poses) == 20 and ahead_m == {0.2}
        return Outcome(holds, f"{got.seen}; the laser {ahead_m} m ahead")

    return tried


def _raw(stage: Stage) -> Outcome:
    got = imported(stage, "carmen", "rawlaser1.log")
    return Outcome(got.has(20, 181, -90, 90) and len(got.odometry) == 20, got.seen)


def _old(name: str, beams: int, right: float, left: float) -> Trial:
    def tried(stage: Stage) -> Outcome:
        got = imported(stage, "carmen", name)
        return Outcome(got.has(20, beams, right, left), got.seen)

    return tried


def _line_ends(stage: Stage) -> Outcome:
    unix, windows = (imported(stage, "carmen", f"mapper-{end}.log") for end in ("lf", "crlf"))
    same = unix.scans == windows.scans and unix.poses == windows.poses
    holds = same and len(unix.poses) == 20 and not unix.odometry and not windows.odometry
    return Outcome(holds, f"LF: {unix.seen}; CRLF: {windows.seen}")


def _without_times(stage: Stage) -> Outcome:
    got = imported(stage, "carmen", "no-tail.log")
    return Outcome(len(got.scans) == 20 and got.report["times_left_out"] == 20, got.seen)


def _centimetres(stage: Stage) -> Outcome:
    got = imported(stage, "carmen", "cm-ranges.log")
    warned = "3,620 beams" in " ".join(got.report.get("notes", ()))
    return Outcome(warned and got.report["no_return"] == 3620, got.seen)


def _other_messages(stage: Stage) -> Outcome:
    got = imported(stage, "carmen", "unknown-messages.log")
    return Outcome(len(got.scans) == 20 and not got.report["broken_lines"], got.seen)


def _decimal_commas(stage: Stage) -> Outcome:
    got = imported(stage, "carmen", "comma-decimals.log")
    named = (
        got.said.status == 2 and "line 6" in got.said.complaint and "comma" in got.said.complaint
    )
    return Outcome(named, got.seen)


def _with_decimals(stage: Stage) -> Outcome:
    got = imported(stage, "coreslam", "floats.dat")
    text = (stage.inputs / "floats.dat").read_text()
    (stage.scratch / "plain.dat").write_text(text.replace(".0 ", " ").replace(".0\n", "\n"))
    plain = imported(Stage(stage.scratch, stage.scratch), "coreslam", "plain.dat")
    same = [scan.ranges for scan in got.scans] == [scan.ranges for scan in plain.scans]
    bytes_same = [s.SerializeToString() for s in got.scans] == [
        s.SerializeToString() for s in plain.scans
    ]
    return Outcome(len(got.scans) == 10 and (same or bytes_same), got.seen)


_SCANS = "20 scans of 181 beams, −90° to +90°, 20 poses"

CASES = (
    Case("carmen", "robotlaser1.log: the present format", _SCANS, _present("robotlaser1.log")),
    Case(
        "carmen",
        "robotlaser1-remission.log: 181 remission values behind the ranges",
        _SCANS,
        _present("robotlaser1-remission.log"),
    ),
    Case("carmen", "rawlaser1.log: no pose, ODOM beside it", "20 scans, 20 odometry", _raw),
    Case("carmen", "flaser180.log", "−90° to +89°", _old("flaser180.log", 180, -90, 89)),
    Case(
        "carmen",
        "flaser401-100deg.log",
        "0.25° a beam, 100° in all",
        _old("flaser401-100deg.log", 401, -50, 50),
    ),
    Case("carmen", "mapper-lf.log, mapper-crlf.log", "the same import", _line_ends),
    Case("carmen", "no-tail.log", "scans without their own time", _without_times),
    Case("carmen", "cm-ranges.log", "a warning: all beams without return", _centimetres),
    Case("carmen", "unknown-messages.log", "20 scans, no broken line", _other_messages),
    Case("carmen", "comma-decimals.log", "refused with the first line's fault", _decimal_commas),
    Case("carmen", "rlaser-only.log", "scans", _old("rlaser-only.log", 181, -90, 90)),
    Case("coreslam", "floats.dat: decimals", "the same distances as without", _with_decimals),
)
