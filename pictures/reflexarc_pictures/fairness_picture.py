"""Draws a world: a stretch of it from above at the start, and its lateral cover profile.

Above: x ahead to the right, y to the left upwards. A pixel is dark if its centre is covered, by the
same test that decides about contacts and about where agents are placed.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from reflexarc_pictures.log_pictures.decision_strips import INK
from reflexarc_pictures.log_pictures.drive import OBSTACLE_COLOUR
from reflexarc_runtime.files import whole_file
from reflexarc_runtime.words.shown import plain
from reflexarc_sim_bridge.evaluation.cover_profile import are_covered, right_side_m
from reflexarc_sim_bridge.evaluation.fairness import FLATNESS, WorldReport
from reflexarc_sim_bridge.worlds.world import World, WorldSource

LENGTH_M = 30.0
MOST_WIDTH_M = 30.0
PIXEL_M = 0.06
_AROUND_WALLS_M = 1.0
_UNFAIR_COLOUR = "#d55e00"


def draw_world(source: WorldSource, report: WorldReport, path: Path) -> None:
    """Write the picture as PNG.

    Args:
        source: the world; a family of worlds gives its first.
        report: the measurements of its check.
        path: the picture; an older one is replaced.
    """
    world = source.drawn(0)
    low_m, high_m = _extent_m(world)
    figure = Figure(figsize=(12.0, 2.0 + 8.0 * (high_m - low_m) / LENGTH_M), dpi=100)
    figure.set_layout_engine("constrained")
    FigureCanvasAgg(figure)
    above, profile = figure.subplots(1, 2, width_ratios=(3.0, 1.0))
    _draw_from_above(above, world, low_m, high_m)
    _draw_profile(profile, report)
    verdict = "fair" if report.fair else "unfair"
    figure.suptitle(
        f"{plain(report.name)}: {verdict}", x=0.01, ha="left", color=INK, parse_math=False
    )
    with whole_file(path) as unfinished:
        figure.savefig(unfinished, format="png", metadata={"Software": None})


def _extent_m(world: World) -> tuple[float, float]:
    """Lowest and highest y of the view from above."""
    if world.corridor is None:
        return 0.0, min(world.width_m, MOST_WIDTH_M)
    right_m = right_side_m(world, 0, np.linspace(0.0, LENGTH_M, 100))
    left_m = right_m + world.corridor.width_m
    return float(right_m.min()) - _AROUND_WALLS_M, float(left_m.max()) + _AROUND_WALLS_M


def _draw_from_above(axes: Axes, world: World, low_m: float, high_m: float) -> None:
    x_m = np.arange(PIXEL_M / 2, LENGTH_M, PIXEL_M)
    y_m = np.arange(low_m + PIXEL_M / 2, high_m, PIXEL_M)
    every_x, every_y = np.meshgrid(x_m, y_m)
    is_covered = are_covered(world, 0, every_x.ravel(), every_y.ravel()).reshape(every_x.shape)
    axes.imshow(
        is_covered,
        origin="lower",
        extent=(0.0, LENGTH_M, low_m, high_m),
        cmap=ListedColormap(["white", OBSTACLE_COLOUR]),
        vmin=0,
        vmax=1,
        interpolation="nearest",
    )
    axes.set(xlabel="ahead (m)", ylabel="to the left (m)")


def _draw_profile(axes: Axes, report: WorldReport) -> None:
    """Cover from side to side with its errors, and the band in which it counts as flat."""
    cover, error = np.array(report.profile), np.array(report.profile_error)
    colour = INK if report.fair else _UNFAIR_COLOUR
    low, high = report.cover * (1.0 - FLATNESS), report.cover * (1.0 + FLATNESS)
    axes.axvspan(low, high, color=OBSTACLE_COLOUR, alpha=0.5, linewidth=0)
    axes.errorbar(cover, report.lateral_m, xerr=2 * error, fmt=".-", color=colour, linewidth=1.0)
    axes.set_xlim(0.0, max(float(cover.max()) * 1.2, 0.01))
    axes.set(xlabel="cover (±2 standard errors)", ylabel="from the right side (m)")
    axes.set_title(f"flat: within {FLATNESS:.0%} of the mean", loc="left", fontsize=9, color=INK)
    axes.spines[["top", "right"]].set_visible(False)
