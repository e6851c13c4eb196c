"""A whole course as one picture: the stretch from above, the last rays, the retina over time."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from reflexarc_pictures.courses.canvas import Canvas
from reflexarc_pictures.courses.course import Course
from reflexarc_pictures.courses.retina_strip import RetinaStrip
from reflexarc_pictures.courses.top_view import TopView
from reflexarc_pictures.log_pictures.decision_strips import INK
from reflexarc_pictures.log_pictures.logged_poses import Floats
from reflexarc_runtime.words.shown import plain
from reflexarc_sim_bridge.worlds.silhouettes import Area

WIDTH_IN, DPI = 8.0, 100
BEHIND_M, AHEAD_M, ASIDE_M = 1.5, 6.0, 4.0
"""How much of the world is shown around the path."""
MOST_ACROSS_M = 24.0
NOSE_M = 0.4
MOST_COLOURS = 96
"""A palette makes the file a third as large."""
_STRIP_IN, _MARGIN_IN = 1.1, 0.55


def draw_stretch(course: Course, path: Path) -> None:
    """Write the picture as PNG."""
    shift_m = _into_the_period(course)
    area = _area(course, shift_m)
    figure = _figure((area.high_y_m - area.low_y_m) / (area.high_x_m - area.low_x_m))
    grid = figure.add_gridspec(
        2, 2, width_ratios=(24, 1), height_ratios=(figure.get_figheight() - 2, _STRIP_IN)
    )
    above = figure.add_subplot(grid[0, :])
    strip, now = figure.add_subplot(grid[1, 0]), figure.add_subplot(grid[1, 1])
    TopView(above, course, NOSE_M).show(len(course.snapshots) - 1, area, shift_m)
    above.tick_params(labelsize=8)
    above.set_xlabel("ahead (m)", fontsize=8.5)
    above.set_ylabel("to the left (m)", fontsize=8.5)
    RetinaStrip(strip, now, course).show(len(course.snapshots) - 1)
    figure.suptitle(_title(course), x=0.01, ha="left", fontsize=11, color=INK, parse_math=False)
    _save(figure, path)


def _title(course: Course) -> str:
    duration_s = (len(course.snapshots) - 1) * course.period_s
    met = len(course.contacts)
    return f"{plain(course.title)}: {duration_s:.0f} s, {met} contact{'' if met == 1 else 's'}"


def _into_the_period(course: Course) -> Floats:
    """What to add to every y so that it lies between 0 and the world's period: (snapshots,)."""
    y_m = np.array([snapshot.y_m for snapshot in course.snapshots])
    if course.lateral_period_m is None or course.strip_m is None:
        return np.zeros(len(y_m))
    shift_m: Floats = -course.lateral_period_m * np.floor(y_m / course.lateral_period_m)
    return shift_m


def _area(course: Course, shift_m: Floats) -> Area:
    x_m = np.array([snapshot.x_m for snapshot in course.snapshots])
    y_m = np.array([snapshot.y_m for snapshot in course.snapshots]) + shift_m
    low_m, high_m = course.strip_m or (float(y_m.min()) - ASIDE_M, float(y_m.max()) + ASIDE_M)
    if high_m - low_m > MOST_ACROSS_M:  # around where it is at the end
        low_m = float(np.clip(y_m[-1] - MOST_ACROSS_M / 2, low_m, high_m - MOST_ACROSS_M))
        high_m = low_m + MOST_ACROSS_M
    return Area(float(x_m.min()) - BEHIND_M, float(x_m.max()) + AHEAD_M, low_m, high_m)


def _save(figure: Figure, path: Path) -> None:
    canvas = Canvas(figure)
    canvas.draw()
    image = canvas.image().quantize(MOST_COLOURS, dither=Image.Dither.NONE)
    image.save(path, format="PNG", optimize=True)


def _figure(slope: float) -> Figure:
    above_in = (WIDTH_IN - _MARGIN_IN) * slope
    return Figure((WIDTH_IN, above_in + 2.2), dpi=DPI, layout="constrained")
