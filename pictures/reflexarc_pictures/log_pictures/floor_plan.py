"""Draws a drive through a real building: a floor plan made of its scans, and strips over time.

The plan shows where beams ended, computed with the poses, and the path, each step in the colour of
the decision that was made there. World frame: x to the right, y upwards, metres.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from reflexarc_logs.reading.reader import Log
from reflexarc_pictures.log_pictures.decision_strips import INK, Decisions, colour_of
from reflexarc_pictures.log_pictures.logged_poses import FARTHEST_M, Floats, Times, poses_of
from reflexarc_pictures.log_pictures.panels import Panels
from reflexarc_runtime.messages.topics import SCAN, TICK
from reflexarc_runtime.sensing.mounting import CENTRED, Mount, mount_of, mounted
from reflexarc_runtime.sensing.scan import Scan, UnusableScanError

MAX_POINTS = 120_000
"""Enough that walls look like lines; more points only make the file larger."""
MARGIN_M = 1.0
FARTHEST_SHARE = 0.002
"""This share of the points on each side (seen through glass, open doors) may be cut off."""


@dataclass(frozen=True)
class FloorPlan:
    """What a picture of a real drive shows."""

    title: str
    ends_m: Floats
    """Where beams ended, x and y: (points, 2)."""
    path_m: Floats
    """Where each tick was decided, x and y: (ticks, 2)."""
    decisions: Decisions


def draw_floor_plan(plan: FloorPlan, path: Path) -> None:
    """Write the picture as PNG."""
    lowest_m, highest_m = _frame(plan)
    width_m, height_m = (highest_m - lowest_m).tolist()
    panels = Panels(plan.decisions, (width_m, height_m))
    assert panels.map is not None
    _draw_walls(panels.map, plan)
    _draw_path(panels.map, plan)
    panels.map.set(xlim=(lowest_m[0], highest_m[0]), ylim=(lowest_m[1], highest_m[1]))
    panels.map.set_aspect("equal", adjustable="box")
    panels.map.set(xlabel="x (m)", ylabel="y (m)")
    panels.save(path, plan.title, [_start(label="start")])


def floor_plan_of(log: Log, decisions: Decisions) -> FloorPlan:
    """Compute the walls that the scans show, and the path.

    Raises:
        LogError: the log is damaged.
    """
    sent_ns, logged_ns, poses = poses_of(log)
    poses[:, 2] = np.unwrap(poses[:, 2])  # so that headings can be interpolated
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
    """Where beams hit an obstacle, x and y in metres: (hits, 2).

    Args:
        scan: as its scanner sits on the robot; none of its beams hits if its angles are none.
        x_m: where the robot is.
        y_m: see `x_m`.
        heading_rad: where it looks.
    """
    seen = mounted(Scan(scan.start_angle, scan.end_angle, np.array(scan.ranges)), _mount(scan))
    if not math.isfinite(seen.start_rad + seen.end_rad):
        return np.empty((0, 2))
    bearings_rad = heading_rad + np.linspace(seen.start_rad, seen.end_rad, len(seen.ranges_m))
    hits = (seen.ranges_m > 0.0) & (seen.ranges_m <= FARTHEST_M)
    ranges_m, bearings_rad = seen.ranges_m[hits], bearings_rad[hits]
    cos, sin = math.cos(heading_rad), math.sin(heading_rad)
    x = x_m + cos * seen.x_m - sin * seen.y_m + ranges_m * np.cos(bearings_rad)
    y = y_m + sin * seen.x_m + cos * seen.y_m + ranges_m * np.sin(bearings_rad)
    return np.stack([x, y], axis=1)


def _mount(scan: LaserScan) -> Mount:
    """How the scanner sits; in the middle if its pose is none."""
    try:
        return mount_of(scan.pose) if scan.HasField("pose") else CENTRED
    except UnusableScanError:
        return CENTRED


def _draw_walls(axes: Axes, plan: FloorPlan) -> None:
    ends_m = plan.ends_m[:: max(1, -(-len(plan.ends_m) // MAX_POINTS))]
    axes.plot(*ends_m.T, ".", color=INK, markersize=1.0, markeredgewidth=0.0, alpha=0.55)


def _draw_path(axes: Axes, plan: FloorPlan) -> None:
    steps = list(np.stack([plan.path_m[:-1], plan.path_m[1:]], axis=1))
    colours = [colour_of(int(action)) for action in plan.decisions.actions[:-1]]
    axes.add_collection(LineCollection(steps, colors="white", linewidths=4.0, zorder=2.5))
    axes.add_collection(LineCollection(steps, colors=colours, linewidths=2.2, zorder=3))
    start = _start(*plan.path_m[:1].T)
    start.set_zorder(4)
    axes.add_line(start)


def _start(x_m: object = (), y_m: object = (), label: str = "") -> Line2D:
    return Line2D(
        np.asarray(x_m, np.float64),
        np.asarray(y_m, np.float64),
        marker="o",
        color="white",
        markeredgecolor=INK,
        linestyle="",
        label=label,
    )


def _frame(plan: FloorPlan) -> tuple[Floats, Floats]:
    """Lower left and upper right corner (m): all of the path, nearly all of the walls."""
    corners = [plan.path_m.min(axis=0), plan.path_m.max(axis=0)]
    if len(plan.ends_m):
        corners += list(np.quantile(plan.ends_m, (FARTHEST_SHARE, 1.0 - FARTHEST_SHARE), axis=0))
    return np.min(corners, axis=0) - MARGIN_M, np.max(corners, axis=0) + MARGIN_M


def _at(times_ns: Times, known_ns: Times, poses: Floats) -> Floats:
    """Poses at other times: (times, 3)."""
    order = np.argsort(known_ns, kind="stable")  # a sender's messages may overtake each other
    columns = [np.interp(times_ns, known_ns[order], column) for column in poses[order].T]
    return np.stack(columns, axis=1)
