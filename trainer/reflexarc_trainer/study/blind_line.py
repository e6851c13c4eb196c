"""The line of an agent that never steers in the figure of a study: what doing nothing costs."""

from collections.abc import Mapping, Sequence

from matplotlib.axes import Axes

from reflexarc_trainer.study.definition import Study
from reflexarc_trainer.study.summary import CellSummary
from reflexarc_trainer.study.unit import Measure

OFF_THE_SCALE = 2.0
"""A line farther off than so many times the largest figure is told in words at the edge."""

_COLOUR = "#555555"
_HALF_ROW = 0.38


def blind_values(study: Study, summaries: Sequence[CellSummary]) -> list[float | None]:
    """What an agent that never steers comes to in each cell, in the measure of the study.

    None where no run says it, and for the edge index, whose mark is that of agents anywhere alike.
    """
    if study.measure is Measure.CONTACTS:
        return [summary.blind for summary in summaries]
    known = {Measure.SHARE_OF_BLIND: 1.0, Measure.SUITE: 0.0}.get(study.measure)
    return [known] * len(summaries)


def draw_blind_line(
    axes: Axes, values: Mapping[str, Sequence[tuple[float, float | None]]], highest: float
) -> None:
    """Draw it across a figure of lines: once, or for each of them where they differ.

    Args:
        axes: of the figure.
        values: by the name of a line, the places of its cells with what a blind agent comes to.
        highest: largest measured figure.
    """
    known = {v for points in values.values() for _, v in points if v is not None}
    if not known:
        return
    if min(known) > OFF_THE_SCALE * highest:
        _say(axes, f"↑ never steering: {_span(known)}")
        return
    label = "never steering"
    for points in values.values():
        told = [(place, value) for place, value in points if value is not None]
        axes.plot(*zip(*told, strict=True), "--", color=_COLOUR, linewidth=1.0, label=label)
        label = "_nolegend_"
        if len(known) == 1:
            return


def draw_blind_marks(axes: Axes, values: Sequence[float | None], highest: float) -> None:
    """Draw it across each row of a figure of rows.

    Args:
        axes: of the figure.
        values: what a blind agent comes to, row by row.
        highest: largest measured figure.
    """
    known = {value for value in values if value is not None}
    if len(known) == 1 and min(known) > OFF_THE_SCALE * highest:
        _say(axes, f"→ never steering: {_span(known)}")
        return
    label = "never steering"
    for row, value in enumerate(values):
        if value is None:
            continue
        if value > OFF_THE_SCALE * highest:
            axes.annotate(
                f"→ {value:.1f} never steering",
                (1.005, row),
                xycoords=("axes fraction", "data"),
                ha="left",
                va="center",
                color=_COLOUR,
                fontsize="small",
            )
            continue
        ends = row - _HALF_ROW, row + _HALF_ROW
        axes.plot([value, value], ends, "--", color=_COLOUR, linewidth=1.0, label=label)
        label = "_nolegend_"


def _say(axes: Axes, words: str) -> None:
    """Above the figure, to the right."""
    where = (1.0, 1.01)
    axes.annotate(words, where, xycoords="axes fraction", ha="right", va="bottom", color=_COLOUR)


def _span(known: set[float]) -> str:
    low, high = f"{min(known):.1f}", f"{max(known):.1f}"
    return low if low == high else f"{low} to {high}"
