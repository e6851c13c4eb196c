"""The poses of a log as arrays."""

import math
from typing import NamedTuple, TypeAlias

import numpy as np
import numpy.typing as npt
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.reading.reader import Log
from reflexarc_runtime.messages.topics import POSE

Floats: TypeAlias = npt.NDArray[np.float64]
Times: TypeAlias = npt.NDArray[np.int64]


FARTHEST_M = 1e6
"""No robot of a picture is farther from where it began, or sees as far; what is, is no place."""


class LoggedPoses(NamedTuple):
    """Where the robot was, in the order of the log."""

    sent_ns: Times
    """On the sender's clock: (poses,)."""
    logged_ns: Times
    """On the recorder's clock: (poses,)."""
    places: Floats
    """x and y in metres, heading in radians within ±2π: (poses, 3)."""


def poses_of(log: Log) -> LoggedPoses:
    """All poses of a log that are places; arrays of no rows if it has none."""
    sent_ns, logged_ns, rows = [], [], []
    for record, message in log.messages(log.topic(POSE.name), PoseInFrame):
        position, turn = message.pose.position, message.pose.orientation
        sent_ns.append(record.publish_ns)
        logged_ns.append(record.log_ns)
        rows.append((position.x, position.y, 2.0 * math.atan2(turn.z, turn.w)))
    places = np.array(rows, np.float64).reshape(-1, 3)
    known = are_places(places)
    sent, logged = np.array(sent_ns, np.int64), np.array(logged_ns, np.int64)
    return LoggedPoses(sent[known], logged[known], places[known])


def are_places(rows: Floats) -> npt.NDArray[np.bool_]:
    """Which rows hold nothing but numbers that a picture can show: (rows,)."""
    known: npt.NDArray[np.bool_] = np.all(np.abs(rows) <= FARTHEST_M, axis=1)  # NaN never is
    return known
