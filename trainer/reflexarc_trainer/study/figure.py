"""The figure of a study: one dot per seed; each cell's interquartile mean with its interval.

If an axis has numbers as values, it is the horizontal axis, and each combination of the other
axes' choices is a line. Otherwise each cell is a row. A dashed line says what an agent that never
steers makes in the same worlds; where that lies far off, its value stands at the edge instead, so
that differences between cells stay visible.
"""

import math
from collections.abc import Sequence

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, NullLocator

from reflexarc_trainer.run.plots import as_png
from reflexarc_trainer.study.axes import AxisScale
from reflexarc_trainer.study.blind_line import blind_values, draw_blind_line, draw_blind_marks
from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.measure_words import FIGURE_NAMES
from reflexarc_trainer.study.summary import CellSummary
from reflexarc_trainer.study.unit import Measure

_INK, _FAINT = "#333333", "#dddddd"
_COLOURS = ("#0b6e4f", "#c9a227", "#a23b3b", "#3b6ea2", "#7a4b94", "#5b8c2a", "#b0683a", "#555555")
"""Colours of the lines or groups of rows, repeated as needed."""
_WIDE = 5.0
"""Ratio of the largest to the smallest measured value above which their scale is logarithmic."""
_WIDTH, _ROW = 8.0, 0.36
"""Width of the figure and height of a row, in inches."""


def draw_study(study: Study, summaries: Sequence[CellSummary]) -> bytes:
    """The figure as PNG."""
    numeric = next((n for n, axis in enumerate(study.axes) if axis.is_numeric), None)
    height = 4.5 if numeric is not None else 1.4 + _ROW * len(summaries)
    figure = Figure(figsize=(_WIDTH, height), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    if numeric is not None:
        _draw_lines(axes, study, summaries, numeric)
    else:
        _draw_rows(axes, study, summaries)
    axes.set_title(study.title, loc="left", color=_INK)
    axes.grid(color=_FAINT, linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    return as_png(figure)


def _draw_lines(axes: Axes, study: Study, summaries: Sequence[CellSummary], numeric: int) -> None:
    lines: dict[str, list[CellSummary]] = {}
    for summary in summaries:
        others = [c.name for n, c in enumerate(summary.cell.choices) if n != numeric]
        lines.setdefault(", ".join(others), []).append(summary)
    is_log = study.axes[numeric].scale is AxisScale.LOG
    if is_log:
        axes.set_xscale("log")
    places = [choice.number or 0.0 for choice in study.axes[numeric].choices]
    for n, (label, line) in enumerate(lines.items()):
        shift = (n - (len(lines) - 1) / 2) * 0.012
        _draw_line(axes, line, label, _shifted(line, numeric, shift, places, is_log), _colour(n))
    draw_blind_line(axes, _blind_points(study, summaries, numeric), _highest(summaries))
    axes.set_xticks(places, [choice.name for choice in study.axes[numeric].choices])
    axes.set_xticks([], minor=True)
    axes.set_xlabel(study.axes[numeric].label)
    _scale_figures(axes, "y", study, summaries)
    if len(axes.get_legend_handles_labels()[1]) > 1:
        axes.legend(frameon=False)


def _blind_points(
    study: Study, summaries: Sequence[CellSummary], numeric: int
) -> dict[str, list[tuple[float, float | None]]]:
    """By line, the places of its cells, and what an agent that never steers comes to there."""
    points: dict[str, list[tuple[float, float | None]]] = {}
    for summary, value in zip(summaries, blind_values(study, summaries), strict=True):
        others = [c.name for n, c in enumerate(summary.cell.choices) if n != numeric]
        place = summary.cell.choices[numeric].number or 0.0
        points.setdefault(", ".join(others), []).append((place, value))
    return points


def _highest(summaries: Sequence[CellSummary]) -> float:
    return max((figure for summary in summaries for figure in summary.figures), default=1.0)


def _shifted(
    line: Sequence[CellSummary],
    numeric: int,
    shift: float,
    places: Sequence[float],
    is_log: bool,
) -> list[float]:
    """Horizontal positions of a line's cells, shifted a little so that intervals do not overlap."""
    own = [summary.cell.choices[numeric].number or 0.0 for summary in line]
    if is_log:
        return [x * (max(places) / min(places)) ** shift for x in own]
    return [x + shift * (max(places) - min(places)) for x in own]


def _draw_line(
    axes: Axes, line: Sequence[CellSummary], label: str, places: Sequence[float], colour: str
) -> None:
    for x, summary in zip(places, line, strict=True):
        seeds = [x] * len(summary.figures)
        axes.plot(seeds, summary.figures, "o", color=colour, markersize=3, alpha=0.45, mew=0)
    known = [(x, s.estimate) for x, s in zip(places, line, strict=True) if s.estimate is not None]
    means = [estimate.value for _, estimate in known]
    below = [estimate.value - estimate.low for _, estimate in known]
    above = [estimate.high - estimate.value for _, estimate in known]
    axes.errorbar(
        [x for x, _ in known],
        means,
        yerr=(below, above),
        fmt="o-",
        color=colour,
        markersize=4.5,
        linewidth=1.2,
        capsize=2.5,
        label=label,
    )


def _draw_rows(axes: Axes, study: Study, summaries: Sequence[CellSummary]) -> None:
    for row, summary in enumerate(summaries):
        colour = _colour(_group(study, summary))
        seeds = [row] * len(summary.figures)
        axes.plot(summary.figures, seeds, "o", color=colour, markersize=3.5, alpha=0.45, mew=0)
        if summary.estimate is None:
            said = "diverged" if summary.diverged else "no result"
            axes.annotate(said, (0.02, row), xycoords=("axes fraction", "data"), va="center")
            continue
        mean, low, high = summary.estimate
        bounds = ([mean - low], [high - mean])
        axes.errorbar([mean], [row], xerr=bounds, fmt="o", color=colour, markersize=5, capsize=3)
    draw_blind_marks(axes, blind_values(study, summaries), _highest(summaries))
    if axes.get_legend_handles_labels()[1]:
        axes.legend(frameon=False, loc="lower right", bbox_to_anchor=(1.0, 1.0))
    axes.set_yticks(range(len(summaries)), [summary.cell.name for summary in summaries])
    axes.set_ylim(len(summaries) - 0.5, -0.5)
    _scale_figures(axes, "x", study, summaries)


def _group(study: Study, summary: CellSummary) -> int:
    """Number of a row's colour: that of its choice on the first of several axes."""
    if len(study.axes) < 2:
        return 0
    return study.axes[0].choices.index(summary.cell.choices[0])


def _scale_figures(axes: Axes, which: str, study: Study, summaries: Sequence[CellSummary]) -> None:
    """Label and scale the axis of the measured values."""
    figures = [figure for summary in summaries for figure in summary.figures]
    name = FIGURE_NAMES[study.measure]
    axis, is_x = (axes.xaxis, True) if which == "x" else (axes.yaxis, False)
    (axes.set_xlabel if is_x else axes.set_ylabel)(name)
    if study.measure is Measure.EDGE_INDEX:
        (axes.axvline if is_x else axes.axhline)(1.0, color=_INK, linestyle="--", linewidth=1.0)
    low, high = min(figures, default=1.0), max(figures, default=1.0)
    if study.measure is Measure.SUITE:
        return  # scores may be below 0, which is where an agent that never steers lies
    if study.measure is not Measure.EDGE_INDEX and 0.0 < _WIDE * low < high:
        (axes.set_xscale if is_x else axes.set_yscale)("log")
        axis.set_major_locator(FixedLocator(_round_numbers(low, high)))
        axis.set_major_formatter(lambda value, _: f"{value:g}")
        axis.set_minor_locator(NullLocator())
    elif is_x:
        axes.set_xlim(left=0.0)
    else:
        axes.set_ylim(bottom=0.0)


def _colour(number: int) -> str:
    return _COLOURS[number % len(_COLOURS)]


def _round_numbers(low: float, high: float) -> list[float]:
    """The numbers 1, 2 and 5 times a power of ten from low / 2 to 2 · high."""
    decades = range(math.floor(math.log10(low)) - 1, math.ceil(math.log10(high)) + 1)
    numbers = [first * 10.0**power for power in decades for first in (1, 2, 5)]
    return [number for number in numbers if low / 2 <= number <= 2 * high]
