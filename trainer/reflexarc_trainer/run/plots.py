"""Pictures of a training run as PNG: its learning curve, and its policy's lateral positions.

Lateral occupancy is the share of the time that agents spend at each position across the world,
with positive y to the left, in metres. A policy that has no preference is equally often everywhere.
"""

import io
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.seeds import validation_seeds
from reflexarc_sim_bridge.worlds.world import World
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.q_network import QNetwork
from reflexarc_trainer.run.history import Row
from reflexarc_trainer.run.validation import GreedyDriver

AGENTS = 256
STEPS = 200
EVERY = 10
"""World steps between two recorded positions of an agent: 1 m at 1 m/s and 0.1 s per step."""
BINS = 40

_VALIDATION, _LEARNING, _BLIND, _INK = "#0b6e4f", "#c9a227", "#a23b3b", "#333333"


def draw_curve(config: TrainConfig, rows: Sequence[Row]) -> bytes:
    """The learning curve as PNG: contacts per 100 m over steps, while learning and greedy."""
    figure, axes = _new_figure(4.5)
    steps = [row.step for row in rows]
    axes.plot(
        steps,
        [row.learning_contacts_per_100m for row in rows],
        color=_LEARNING,
        linewidth=1.2,
        label="while learning (random actions included)",
    )
    validation = [row.validation_contacts_per_100m for row in rows]
    axes.plot(
        steps, validation, "o-", color=_VALIDATION, markersize=3.5, label="greedy, validation"
    )
    world = config.goal_world
    blind = world.blind_contacts_per_100m if isinstance(world, World) else None
    if blind is not None:
        _draw_level(axes, blind, f"blind: {blind:.1f}")
    title = f"{config.preset} in {config.goal.name}, seed {config.seed}"
    _label(axes, title, "steps", "contacts per 100 m")
    axes.set_xlim(0, config.steps)
    axes.set_ylim(bottom=0)
    axes.xaxis.set_major_formatter(
        lambda step, _: f"{step / 1e6:g} M" if step >= 1e5 else f"{step:g}"
    )
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.legend(frameon=False)
    return as_png(figure)


def draw_occupancy(network: QNetwork, config: TrainConfig) -> bytes:
    """Share of the time at each lateral position, as PNG."""
    positions_m = lateral_positions_m(network, config)
    figure, axes = _new_figure(2.8)
    share = np.full(len(positions_m), 100.0 / len(positions_m))
    shares, _, _ = axes.hist(positions_m, bins=BINS, weights=share, color=_VALIDATION, linewidth=0)
    axes.set_ylim(0.0, 1.3 * float(np.max(shares)))  # room for the legend above the bars
    _draw_level(axes, 100.0 / BINS, "even")
    _label(axes, f"lateral occupancy in {config.goal.name}", "y, m to the left", "% of the time")
    axes.legend(frameon=False, loc="upper right")
    return as_png(figure)


def lateral_positions_m(network: QNetwork, config: TrainConfig) -> npt.NDArray[np.float64]:
    """Lateral positions (n,) of agents in validation worlds, driven by the greedy policy."""
    simulation = Simulation(config.goal_world, config.contract(), validation_seeds(AGENTS))
    driver, positions_m = GreedyDriver(network, config, simulation), []
    for _ in range(STEPS // EVERY):
        driver.drive(EVERY)
        positions_m.append(simulation.y_m)
    return np.concatenate(positions_m)


def as_png(figure: Figure) -> bytes:
    """A figure as the content of a PNG file, without matplotlib's version in it."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def _new_figure(height_inches: float) -> tuple[Figure, Axes]:
    figure = Figure(figsize=(8.0, height_inches), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    return figure, figure.add_subplot()


def _draw_level(axes: Axes, value: float, label: str) -> None:
    axes.axhline(value, color=_BLIND, linestyle="--", linewidth=1.0, label=label)


def _label(axes: Axes, title: str, x: str, y: str) -> None:
    axes.set_title(title, loc="left", color=_INK)
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.spines[["top", "right"]].set_visible(False)
