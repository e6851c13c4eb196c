"""A drive as a picture: from above, and what the policy saw and did as strips over time.

Above: obstacles, path and contacts, x ahead to the right, y to the left upwards. Without poses
there is no view from above.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.lines import Line2D
from matplotlib.patches import Ellipse, Patch, Polygon, Rectangle

from reflexarc_pictures.log_pictures.decision_strips import INK, Decisions, Floats
from reflexarc_pictures.log_pictures.panels import Panels

OBSTACLE_COLOUR, CONTACT_COLOUR = "#9fb3c8", "#f2a900"
MARGIN_M = 4.0
JUMP_M = 0.5
"""No body moves as far within a tick: it was put elsewhere."""


@dataclass(frozen=True)
class Drive:
    """What a picture of a drive shows."""

    title: str
    x_m: Floats
    """Path ahead: (poses,)."""
    y_m: Floats
    """Path to the left, within the world's period: (poses,)."""
    contacts: Floats
    """Where collisions began, x and y: (contacts, 2)."""
    boxes: Floats
    """Rectangles: centre x and y, length along x, width along y: (boxes, 4)."""
    discs: Floats
    """Discs: the same with the diameter twice: (discs, 4)."""
    polygons: Sequence[Floats]
    """Corners of other obstacles, each (corners, 2)."""
    decisions: Decisions


def draw_drive(drive: Drive, path: Path) -> None:
    """Write the picture as PNG."""
    if not len(drive.x_m):
        Panels(drive.decisions, None).save(path, f"{drive.title}, no poses")
        return
    lowest_m = np.array([drive.x_m.min(), drive.y_m.min()]) - MARGIN_M
    highest_m = np.array([drive.x_m.max(), drive.y_m.max()]) + MARGIN_M
    width_m, height_m = (highest_m - lowest_m).tolist()
    panels = Panels(drive.decisions, (width_m, height_m))
    assert panels.map is not None
    contacts = _draw_from_above(panels.map, drive)
    panels.map.set(xlim=(lowest_m[0], highest_m[0]), ylim=(lowest_m[1], highest_m[1]))
    panels.map.set_aspect("equal", adjustable="box")
    panels.map.set(xlabel="ahead (m)", ylabel="to the left (m)")
    panels.save(path, drive.title, contacts)


def _draw_from_above(axes: Axes, drive: Drive) -> list[Line2D]:
    """Obstacles, path and contacts; returns the entry of the contacts in a legend, if any."""
    shapes: list[Patch] = [
        Rectangle((x - length / 2, y - width / 2), length, width)
        for x, y, length, width in drive.boxes
    ]
    shapes += [Ellipse((x, y), length, width) for x, y, length, width in drive.discs]
    shapes += [Polygon(corners_m) for corners_m in drive.polygons]
    axes.add_collection(PatchCollection(shapes, facecolor=OBSTACLE_COLOUR, edgecolor="none"))
    axes.plot(*_broken_at_jumps(drive.x_m, drive.y_m), color=INK, linewidth=1.6)
    if not len(drive.contacts):
        return []
    label = f"contact: {len(drive.contacts)}"
    return axes.plot(*drive.contacts.T, "o", color=CONTACT_COLOUR, markeredgecolor=INK, label=label)


def _broken_at_jumps(x_m: Floats, y_m: Floats) -> tuple[Floats, Floats]:
    """The path with gaps where the body went on elsewhere: at a respawn or across the period."""
    jumps = np.flatnonzero(np.abs(np.diff(y_m)) > JUMP_M) + 1
    return np.insert(x_m, jumps, np.nan), np.insert(y_m, jumps, np.nan)
