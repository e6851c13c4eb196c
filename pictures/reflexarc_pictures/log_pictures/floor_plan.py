"""A drive through a real building as a picture: a floor plan out of its scans, strips over time.

The plan shows where beams ended, put together by the poses, and the path, each step in the colour
of the decision that was made there. World frame: x to the right, y upwards, metres.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.lines import Line2D

from reflexarc_pictures.log_pictures.decision_strips import INK, Decisions, Floats, colour_of
from reflexarc_pictures.log_pictures.panels import Panels

MAX_POINTS = 120_000
"""Enough for walls to become lines; more only makes the picture large."""
MARGIN_M = 1.0
FARTHEST_SHARE = 0.002
"""What lies beyond this share of the points on a side (glass, open doors) is outside the frame."""


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
