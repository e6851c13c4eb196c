"""What a log says about a building: where beams ended, and where each decision was made.

A beam of length r at angle a, sent from the pose (x, y, heading), ended at
(x + r cos(heading + a), y + r sin(heading + a)). Scans are matched with poses on the sender's
clock, ticks with poses on the recorder's, by linear interpolation. The scanner sits at the pose.
"""

import math

import numpy as np
import numpy.typing as npt
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.reading.reader import Log
from reflexarc_pictures.log_pictures.decision_strips import Decisions, Floats
from reflexarc_pictures.log_pictures.floor_plan import FloorPlan
from reflexarc_runtime.messages.topics import POSE, SCAN, TICK


def floor_plan_of(log: Log, decisions: Decisions) -> FloorPlan:
    """The walls that the scans show, and the path.

    Raises:
        LogError: the log is damaged.
    """
    sent_ns, logged_ns, poses = _poses(log)
    ticked_ns = np.array([tick.log_ns for tick in log.records(log.topic(TICK.name))])
    scans = list(log.messages(log.topic(SCAN.name), LaserScan))
    places = _at(np.array([record.publish_ns for record, _ in scans]), sent_ns, poses)
    ends = [beam_ends(scan, *place) for (_, scan), place in zip(scans, places, strict=True)]
    return FloorPlan(
        title=f"{log.path.name}: {len(scans)} scans, {len(ticked_ns)} decisions",
        ends_m=np.concatenate(ends),
        path_m=_at(ticked_ns, logged_ns, poses)[:, :2],
        decisions=decisions,
    )


def beam_ends(scan: LaserScan, x_m: float, y_m: float, heading_rad: float) -> Floats:
    """Where the beams ended that met something, x and y in metres: (hits, 2)."""
    ranges_m = np.array(scan.ranges, np.float64)
    bearings_rad = heading_rad + np.linspace(scan.start_angle, scan.end_angle, len(ranges_m))
    hits = np.isfinite(ranges_m) & (ranges_m > 0.0)
    ranges_m, bearings_rad = ranges_m[hits], bearings_rad[hits]
    x, y = x_m + ranges_m * np.cos(bearings_rad), y_m + ranges_m * np.sin(bearings_rad)
    return np.stack([x, y], axis=1)


def _poses(log: Log) -> tuple[Floats, Floats, Floats]:
    """When each pose was sent and when it was recorded (poses,), and x, y, heading (poses, 3)."""
    sent_ns, logged_ns, rows = [], [], []
    for record, message in log.messages(log.topic(POSE.name), PoseInFrame):
        position, turn = message.pose.position, message.pose.orientation
        sent_ns.append(record.publish_ns)
        logged_ns.append(record.log_ns)
        rows.append((position.x, position.y, 2.0 * math.atan2(turn.z, turn.w)))
    poses = np.array(rows, np.float64)
    poses[:, 2] = np.unwrap(poses[:, 2])  # so that headings can be interpolated
    return np.array(sent_ns, np.float64), np.array(logged_ns, np.float64), poses


def _at(times_ns: npt.NDArray[np.int64], known_ns: Floats, poses: Floats) -> Floats:
    """Poses at other times: (times, 3)."""
    order = np.argsort(known_ns, kind="stable")  # a sender's messages may overtake each other
    columns = [np.interp(times_ns, known_ns[order], column) for column in poses[order].T]
    return np.stack(columns, axis=1)
