"""Draws what a policy saw, its Q-values and its actions as strips over time.

Each strip shows a decision from its own time until the next one; all share one time axis (s). When
the policy was not asked, retina and Q-values are missing, and the safe command was sent: grey.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from reflexarc_logs.reading.reader import Log
from reflexarc_pictures.log_pictures.logged_poses import Floats
from reflexarc_runtime.arrays import Actions
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import Shading
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.messages_pb2 import Decision
from reflexarc_runtime.policy.policy import load_contract

INK, SAFE_COLOUR = "#22313f", "#b4bcc4"
ACTION_COLOURS = (
    *("#009e73", "#0072b2", "#d55e00"),  # the paper's three: stay, left, right
    *("#cc79a7", "#e69f00", "#56b4e9", "#f0e442"),
)
"""A colour for each action, repeated if there are more; colour-blind readers can tell them apart.
Source: Okabe and Ito, "Color Universal Design" (2008)."""
COLUMNS = 1600
"""More than the pixels in a row of a picture."""
BRIGHT = {Shading.NEARNESS: "near", Shading.COLOUR: "brightly coloured"}


@dataclass(frozen=True)
class Decisions:
    """The decisions of all ticks, in order; at least one."""

    time_s: Floats
    """From the first tick on: (ticks,)."""
    retinas: Floats
    """The newest retina of each tick, 0 to 255; NaN if the policy was not asked: (ticks, rays)."""
    q_values: Floats
    """NaN if the policy was not asked: (ticks, actions)."""
    actions: Actions
    """Index of each action, −1 for the safe command: (ticks,)."""
    action_names: tuple[str, ...]
    bright: str
    """What a large value in a retina means."""


def colour_of(action: int) -> str:
    """The colour of an action, in every strip and on every map; −1 is the safe command."""
    return SAFE_COLOUR if action < 0 else ACTION_COLOURS[action % len(ACTION_COLOURS)]


def draw_retinas(axes: Axes, decisions: Decisions) -> None:
    """Draw the retinas as columns, the leftmost ray on top; brighter is a larger value."""
    moments = _sampled(decisions.time_s)
    axes.imshow(
        decisions.retinas[moments].T,
        aspect="auto",
        cmap=colormaps["magma"].with_extremes(bad=SAFE_COLOUR),
        vmin=0,
        vmax=255,
        interpolation="nearest",
        extent=(0.0, _end_s(decisions), decisions.retinas.shape[1], 0.0),
    )
    _entitle(axes, f"what the policy saw (bright: {decisions.bright})", "ray (0: leftmost)")
    axes.yaxis.set_major_locator(MaxNLocator(5, integer=True))
    axes.tick_params(labelbottom=False)


def draw_q_values(axes: Axes, decisions: Decisions) -> None:
    """Draw a line for each action; the policy takes the highest one."""
    for action in range(decisions.q_values.shape[1]):
        values = decisions.q_values[:, action]
        axes.step(
            decisions.time_s,
            values,
            where="post",
            color=colour_of(action),
            linewidth=0.8,
            alpha=0.9,
        )
    axes.set_xlim(0.0, _end_s(decisions))
    axes.grid(color="#e3e7eb", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    _entitle(axes, "how it valued each action", "Q-value")
    axes.tick_params(labelbottom=False)


def draw_actions(axes: Axes, decisions: Decisions) -> None:
    """Draw the actions as bars in their colours, with the time axis of all strips."""
    shown = range(-1, len(decisions.action_names))
    axes.imshow(
        decisions.actions[np.newaxis, _sampled(decisions.time_s)],
        aspect="auto",
        cmap=ListedColormap([colour_of(action) for action in shown]),
        vmin=-1,
        vmax=len(decisions.action_names) - 1,
        interpolation="nearest",
        extent=(0.0, _end_s(decisions), 0.0, 1.0),
    )
    axes.set_yticks([])
    axes.set_xlabel("time (s)")
    _entitle(axes, "what it decided", "")


def action_patches(decisions: Decisions) -> list[Patch]:
    """Entries of a legend with their counts: the actions, and the safe command if it was sent."""
    shown = [*enumerate(decisions.action_names)]
    if (decisions.actions < 0).any():
        shown.append((-1, "safe command"))
    return [
        Patch(facecolor=colour_of(action), label=f"{name}: {(decisions.actions == action).sum()}")
        for action, name in shown
    ]


def decisions_of(log: Log) -> Decisions:
    """Every tick of a log, in order.

    Raises:
        LogError: the log has no ticks, or no policy.
    """
    made = [tick.decision for tick in log.ticks()]
    if not made or log.policy is None:
        raise LogError(
            f"{log.path}: expected the ticks and the policy of `reflexarc run --record`, found "
            f"{'no ticks' if not made else 'no policy'}; play it into a runtime that records"
        )
    contract = load_contract(log.policy, bounds=None)
    return Decisions(
        time_s=np.array([decision.now_ns - made[0].now_ns for decision in made]) * 1e-9,
        retinas=_retinas(made, contract),
        q_values=_q_values(made, contract),
        actions=np.array([decision.action for decision in made], np.int64),
        action_names=tuple(action.name for action in contract.actions),
        bright=BRIGHT[contract.retina.shading],
    )


def _sampled(time_s: Floats) -> npt.NDArray[np.int64]:
    """Index of the last tick before the middle of each column; ticks may be uneven in time."""
    grid_s = (np.arange(COLUMNS) + 0.5) / COLUMNS * time_s[-1]
    held: npt.NDArray[np.int64] = np.maximum(np.searchsorted(time_s, grid_s, side="right") - 1, 0)
    return held


def _end_s(decisions: Decisions) -> float:
    return float(decisions.time_s[-1]) or 1.0


def _entitle(axes: Axes, title: str, unit: str) -> None:
    axes.set_title(title, loc="left", fontsize=10, color=INK)
    axes.set_ylabel(unit, fontsize=9)
    axes.tick_params(labelsize=8.5)


def _retinas(made: Sequence[Decision], contract: PolicyContract) -> Floats:
    """The newest retina of each stack, of each ray its brightest channel: (ticks, rays)."""
    eye = contract.retina
    retinas = np.full((len(made), eye.eyes * eye.rays), np.nan)
    for row, decision in zip(retinas, made, strict=True):
        if len(decision.retina) == eye.frames * eye.size:
            newest = np.frombuffer(decision.retina, np.uint8)[-eye.size :]
            row[:] = newest.reshape(-1, eye.channels).max(axis=1)
    return retinas


def _q_values(made: Sequence[Decision], contract: PolicyContract) -> Floats:
    actions = len(contract.actions)
    values = np.full((len(made), actions), np.nan)
    for row, decision in zip(values, made, strict=True):
        if len(decision.q_values) == actions:
            row[:] = decision.q_values
    return values
