"""The layout of a picture of a log: a map, beside or above strips that share a legend."""

from collections.abc import Sequence
from pathlib import Path

from matplotlib import rc_context
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from reflexarc_pictures.log_pictures.decision_strips import (
    INK,
    Decisions,
    action_patches,
    draw_actions,
    draw_q_values,
    draw_retinas,
)
from reflexarc_runtime.words.shown import plain

WIDE = 1.6
"""A map at least so many times wider than high is above its strips, not beside them."""
_HEIGHTS = (2.2, 2.0, 0.35)
"""Heights of the three strips, in proportion."""
_WORDS = rc_context({"text.parse_math": False})
"""Names of files and actions are words: what stands between two `$` is no formula."""


class Panels:
    """The parts of one picture.

    Args:
        decisions: what the strips show.
        extent_m: width and height of the map; None: there is no map.
    """

    @_WORDS
    def __init__(self, decisions: Decisions, extent_m: tuple[float, float] | None) -> None:
        if extent_m is None:
            self._figure, self.map, strips = _strips_only()
        elif extent_m[0] > WIDE * extent_m[1]:
            self._figure, self.map, strips = _above_each_other(extent_m[1] / extent_m[0])
        else:
            self._figure, self.map, strips = _beside_each_other()
        for draw, axes in zip((draw_retinas, draw_q_values, draw_actions), strips, strict=True):
            draw(axes, decisions)
        self._entries: list[Artist] = [*action_patches(decisions)]

    @_WORDS
    def save(self, path: Path, title: str, entries: Sequence[Artist] = ()) -> None:
        """Add title and legend, with more entries where there are some, and write a PNG."""
        self._figure.suptitle(plain(title), x=0.01, ha="left", color=INK)
        handles = [*self._entries, *entries]
        self._figure.legend(
            handles=handles, loc="outside lower center", ncols=len(handles), frameon=False
        )
        self._figure.savefig(path, format="png", metadata={"Software": None})


def _strips_only() -> tuple[Figure, None, list[Axes]]:
    figure = _figure(12.0, 4.6)
    grid = figure.add_gridspec(3, 1, height_ratios=_HEIGHTS)
    return figure, None, [figure.add_subplot(grid[row, 0]) for row in range(3)]


def _above_each_other(slope: float) -> tuple[Figure, Axes, list[Axes]]:
    map_in = 12.0 * slope
    figure = _figure(12.0, map_in + 5.6)
    grid = figure.add_gridspec(4, 1, height_ratios=(map_in + 0.3, *_HEIGHTS))
    above, *strips = (figure.add_subplot(grid[row, 0]) for row in range(4))
    return figure, above, strips


def _beside_each_other() -> tuple[Figure, Axes, list[Axes]]:
    figure = _figure(14.0, 7.2)
    grid = figure.add_gridspec(3, 2, height_ratios=_HEIGHTS)
    above = figure.add_subplot(grid[:, 0])
    return figure, above, [figure.add_subplot(grid[row, 1]) for row in range(3)]


def _figure(width_in: float, height_in: float) -> Figure:
    figure = Figure(figsize=(width_in, height_in), dpi=100, layout="constrained")
    FigureCanvasAgg(figure)
    return figure
