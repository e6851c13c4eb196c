"""The figure of the race: contacts per 100 m over time, with one panel per group of contenders."""

import io

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from learning_race.judge import LEVELS
from learning_race.results import Run, group_of
from reflexarc_sim_bridge.evaluation.scoring.statistics import estimate

Floats = npt.NDArray[np.float64]
PANELS = {
    "ours": ("ours", "ablation"),
    "Stable-Baselines3, tuned": ("tuned",),
    "Stable-Baselines3: defaults, and 16–10–3": ("default", "matched"),
}
REFERENCE = "reflex-short"
"""Contender that is shown in every panel."""
COLOURS = ("#0b6e4f", "#c9a227", "#a23b3b", "#2d5d9f", "#7a4fa3", "#777777")
LOOKED_AT = 0.8
"""A line begins when this share of the seeds has had a look."""
TIMES_S = np.geomspace(0.002, 60.0, 200)


def draw(runs: dict[str, list[Run]]) -> bytes:
    """The figure as PNG: interquartile means over seeds with 95 % bands, on validation worlds."""
    shown = {title: groups for title, groups in PANELS.items() if _names(runs, groups)} or PANELS
    figure = Figure(figsize=(4.5 * len(shown), 5.0), dpi=140, layout="constrained")
    FigureCanvasAgg(figure)
    panels = figure.subplots(1, len(shown), sharex=True, sharey=True, squeeze=False)[0]
    for axes, (title, groups) in zip(panels, shown.items(), strict=True):
        axes.set_title(title, loc="left")
        if "ours" not in groups and REFERENCE in runs:
            _line(axes, f"{REFERENCE} (ours)", runs[REFERENCE], "#bbbbbb")
        for name, colour in zip(_names(runs, groups), COLOURS, strict=False):
            _line(axes, name, runs[name], colour)
        _dress(axes)
    panels[0].set_ylabel("contacts per 100 m, greedy, validation worlds")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _names(runs: dict[str, list[Run]], groups: tuple[str, ...]) -> list[str]:
    return [name for name in runs if group_of(name) in groups]


def _line(axes: Axes, name: str, runs: list[Run], colour: str) -> None:
    end_s = min(run.seconds for run in runs)
    firsts_s = [run.looks[0].seconds for run in runs]
    begin_s = np.quantile(firsts_s, LOOKED_AT, method="lower")
    times_s = TIMES_S[(begin_s <= TIMES_S) & (end_s >= TIMES_S)]
    if not len(times_s):
        return
    curves = np.array([_at(run, times_s) for run in runs])
    middle, low, high = np.array([estimate(column) for column in curves.T]).T
    axes.plot(times_s, middle, color=colour, linewidth=1.6, label=name)
    axes.fill_between(times_s, low, high, color=colour, alpha=0.18, linewidth=0)


def _at(run: Run, times_s: Floats) -> Floats:
    """Result of the last look before each time; before the first look, the first result."""
    seen_s = np.array([look.seconds for look in run.looks])
    rates = np.array([look.contacts_per_100m for look in run.looks])
    last = np.searchsorted(seen_s, times_s, side="right") - 1
    found: Floats = rates[np.maximum(last, 0)]
    return found


def _dress(axes: Axes) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlim(TIMES_S[0], TIMES_S[-1])
    axes.set_ylim(1.5, 80.0)
    axes.set_yticks([2, 3, *LEVELS, 10, 20, 36, 70], minor=False)
    axes.set_yticks([], minor=True)
    axes.yaxis.set_major_formatter(lambda rate, _: f"{rate:g}")
    axes.xaxis.set_major_formatter(lambda seconds, _: f"{seconds:g}")
    for level in LEVELS:
        axes.axhline(level, color="#cccccc", linewidth=0.7, zorder=0)
    axes.set_xlabel("seconds of learning, warm")
    axes.spines[["top", "right"]].set_visible(False)
    if axes.get_legend_handles_labels()[0]:
        axes.legend(
            frameon=False, fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=(0.5, -0.12)
        )
