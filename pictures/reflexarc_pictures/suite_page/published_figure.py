"""The published figure of a suite: each contender's score by family, in one picture.

A row for each contender, the best headline score on top; a column for each family, and the
headline before them, with its interval as a line. Colours are those of the page.
"""

from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from reflexarc_pictures.log_pictures.decision_strips import INK
from reflexarc_pictures.suite_page.page_content import Entry, PageContent
from reflexarc_pictures.suite_page.plot import shortened
from reflexarc_pictures.suite_page.told import number
from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.files import whole_file
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting

_WORSE_ZERO_BETTER = LinearSegmentedColormap.from_list(
    "score", ["#a63603", "#f6f6f4", "#08519c"], N=255
)
_SOFT, _BAR = "#5b6670", "#0072b2"
_ROW_IN, _COLUMN_IN, _BAR_IN, _NAMES_IN, _HEAD_IN = 0.34, 0.72, 2.2, 2.6, 1.15
_MOST = 36
"""Characters of a name."""
_DARK = 0.55
"""A score beyond this, either way, has a ground on which white is read better."""


def draw_scores(content: PageContent, path: Path, setting: Setting | None = None) -> None:
    """Write the picture as PNG.

    Args:
        content: results and scores.
        path: the picture; an older one is replaced.
        setting: whose scores; None: the first that was measured.

    Raises:
        UsageError: nobody was measured in that setting.
    """
    if setting is None and content.settings:
        setting = content.settings[0]
    entries = [entry for entry in content.entries if setting in entry.cards]
    if setting is None or not entries:
        raise UsageError("figure: expected results of one contender or more, got none")
    families = [
        family
        for family in content.families
        if any(family in entry.cards[setting].families for entry in entries)
    ]
    figure = _figure(len(entries), len(families))
    bars, heat = figure.subplots(
        1, 2, width_ratios=(_BAR_IN, _COLUMN_IN * len(families)), sharey=True
    )
    _draw_headlines(bars, entries, setting)
    _draw_families(heat, entries, families, setting)
    title = f"{content.results.suite}, {setting}: 0 never steers, 1 is what is possible"
    figure.suptitle(title, x=0.01, ha="left", fontsize=11, color=INK, parse_math=False)
    with whole_file(path) as unfinished:
        figure.savefig(unfinished, format="png", metadata={"Software": None})


def _figure(entries: int, families: int) -> Figure:
    width_in = _NAMES_IN + _BAR_IN + _COLUMN_IN * families
    figure = Figure((width_in, _HEAD_IN + _ROW_IN * entries), dpi=140, layout="constrained")
    FigureCanvasAgg(figure)
    return figure


def _draw_headlines(axes: Axes, entries: list[Entry], setting: Setting) -> None:
    scores = [entry.cards[setting].headline for entry in entries]
    places = range(len(entries))
    axes.barh(places, [score.value for score in scores], height=0.55, color=_BAR)
    for place, score in zip(places, scores, strict=True):
        if score.low is not None and score.high is not None:
            axes.plot([score.low, score.high], [place, place], color=INK, linewidth=1.6)
        end = max(0.0, score.value if score.high is None else score.high)
        axes.text(end + 0.03, place, number(score.value), va="center", fontsize=9, color=INK)
    axes.axvline(0.0, color=_SOFT, linewidth=0.8)
    lowest = min([0.0, *(score.value if score.low is None else score.low for score in scores)])
    axes.set_xlim(min(lowest - 0.02, -0.02), 1.2)
    axes.set_xticks([0.0, 0.5, 1.0])
    axes.set_yticks(places, [shortened(entry.name, _MOST) for entry in entries], parse_math=False)
    axes.set_ylim(len(entries) - 0.5, -0.5)
    axes.tick_params(length=0, labelsize=9, colors=INK)
    axes.set_title("mean over families", loc="left", fontsize=9, color=_SOFT)
    axes.spines[:].set_visible(False)


def _draw_families(axes: Axes, entries: list[Entry], families: list[str], setting: Setting) -> None:
    scores = np.full((len(entries), len(families)), np.nan)
    for place, entry in enumerate(entries):
        for column, family in enumerate(families):
            known = entry.cards[setting].families.get(family)
            scores[place, column] = np.nan if known is None else known.value
            _write(axes, column, place, scores[place, column])
    axes.imshow(scores, cmap=_WORSE_ZERO_BETTER, vmin=-1.0, vmax=1.0, aspect="auto")
    for border in np.arange(0.5, len(families) - 1):
        axes.axvline(border, color="white", linewidth=2.0)
    for border in np.arange(0.5, len(entries) - 1):
        axes.axhline(border, color="white", linewidth=2.0)
    axes.xaxis.tick_top()
    axes.set_xticks(np.arange(len(families)), families, parse_math=False)
    axes.tick_params(length=0, labelsize=8.5, colors=INK, labelleft=False)
    axes.spines[:].set_visible(False)


def _write(axes: Axes, column: int, place: int, score: float) -> None:
    ink = "white" if abs(score) > _DARK else INK
    axes.text(column, place, number(score), ha="center", va="center", fontsize=9, color=ink)
