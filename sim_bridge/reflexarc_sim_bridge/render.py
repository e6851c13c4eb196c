"""A drive as a picture: from above, and what the eye saw as a strip over time.

Above: obstacles, path and contacts, x ahead to the right, y to the left upwards. Below: one column
a tick, the leftmost ray on top, brighter is a larger value; under it the action of each tick.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

import matplotlib as mpl
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.collections import PatchCollection
from matplotlib.figure import Figure
from matplotlib.patches import Ellipse, Patch, Rectangle

INK, PATH_COLOUR, OBSTACLE_COLOUR, CONTACT_COLOUR = "#22313f", "#d1495b", "#9fb3c8", "#f2a900"
ACTION_COLOURS = ("#e6ebf0", "#3d7ea6", "#d1495b")
MARGIN_M = 4.0

Floats: TypeAlias = npt.NDArray[np.float64]


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
    time_s: Floats
    """Time of each tick: (ticks,)."""
    retinas: npt.NDArray[np.uint8]
    """What the policy was given: (ticks, rays)."""
    actions: npt.NDArray[np.int64]
    """Index of the action of each tick, −1 for the safe command: (ticks,)."""
    action_names: tuple[str, ...]


def draw_drive(drive: Drive, path: Path) -> None:
    """Write the picture as PNG."""
    mpl.use("agg")
    figure = Figure(figsize=(12.0, 6.6), dpi=110, layout="constrained")
    above, strip, acts = figure.subplots(3, 1, height_ratios=(5.0, 2.4, 0.5))
    _draw_from_above(above, drive)
    _draw_strip(strip, drive)
    _draw_actions(acts, drive)
    figure.savefig(path, format="png")


def _draw_from_above(axes: Axes, drive: Drive) -> None:
    shapes: list[Patch] = [
        Rectangle((x - length / 2, y - width / 2), length, width)
        for x, y, length, width in drive.boxes
    ]
    shapes += [Ellipse((x, y), length, width) for x, y, length, width in drive.discs]
    axes.add_collection(PatchCollection(shapes, facecolor=OBSTACLE_COLOUR, edgecolor="none"))
    axes.plot(*_broken_at_jumps(drive.x_m, drive.y_m), color=PATH_COLOUR, linewidth=1.6)
    if len(drive.contacts):
        axes.plot(
            *drive.contacts.T, "o", color=CONTACT_COLOUR, markeredgecolor=INK, label="contact"
        )
        axes.legend(loc="upper right", frameon=False)
    axes.set_xlim(drive.x_m.min() - MARGIN_M, drive.x_m.max() + MARGIN_M)
    axes.set_ylim(drive.y_m.min() - MARGIN_M, drive.y_m.max() + MARGIN_M)
    axes.set_aspect("equal", adjustable="box", anchor="W")
    axes.set_title(drive.title, loc="left", color=INK)
    axes.set_xlabel("ahead (m)")
    axes.set_ylabel("to the left (m)")


def _draw_strip(axes: Axes, drive: Drive) -> None:
    end_s = drive.time_s[-1] if len(drive.time_s) else 1.0
    rays = drive.retinas.shape[1]
    axes.imshow(
        drive.retinas.T,
        aspect="auto",
        cmap="magma",
        vmin=0,
        vmax=255,
        interpolation="nearest",
        extent=(0.0, float(end_s), rays, 0.0),
    )
    axes.set_ylabel("ray (0 = leftmost)")
    axes.set_title("what the policy saw", loc="left", fontsize=10, color=INK)
    axes.tick_params(labelbottom=False)


def _draw_actions(axes: Axes, drive: Drive) -> None:
    end_s = drive.time_s[-1] if len(drive.time_s) else 1.0
    palette = mpl.colors.ListedColormap(["#ffffff", *ACTION_COLOURS])
    axes.imshow(
        drive.actions[np.newaxis],
        aspect="auto",
        cmap=palette,
        vmin=-1,
        vmax=2,
        interpolation="nearest",
        extent=(0.0, float(end_s), 0.0, 1.0),
    )
    axes.set_yticks([])
    axes.set_xlabel("time (s)")
    handles = [
        Patch(facecolor=colour, label=name)
        for colour, name in zip(ACTION_COLOURS, drive.action_names, strict=False)
    ]
    axes.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), frameon=False)


def _broken_at_jumps(x_m: Floats, y_m: Floats) -> tuple[Floats, Floats]:
    """The path with gaps where the body went on elsewhere: at a respawn or across the period."""
    jumps = np.flatnonzero(np.abs(np.diff(y_m)) > 0.5) + 1
    return np.insert(x_m, jumps, np.nan), np.insert(y_m, jumps, np.nan)
