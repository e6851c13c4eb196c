"""Pictures of a training run: its learning curve, and where across the world the policy drives."""

import io
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt
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
"""Steps between two looks at where an agent is: a metre on, at the usual speed."""


BINS = 40


_VALIDATION, _LEARNING, _BLIND, _INK = "#0b6e4f", "#c9a227", "#a23b3b", "#333333"


def draw_curve(config: TrainConfig, rows: Sequence[Row]) -> bytes:
    """Contacts per 100 m over steps, as PNG: while learning, greedy on validation worlds, blind."""
    figure = Figure(figsize=(8.0, 4.5), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
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
        label = f"blind: {blind:.1f}"
        axes.axhline(blind, color=_BLIND, linestyle="--", linewidth=1.0, label=label)
    axes.set_title(
        f"{config.preset} in {config.goal.name}, seed {config.seed}", loc="left", color=_INK
    )
    axes.set_xlabel("steps")
    axes.set_ylabel("contacts per 100 m")
    axes.set_xlim(0, config.steps)
    axes.set_ylim(bottom=0)
    axes.xaxis.set_major_formatter(
        lambda step, _: f"{step / 1e6:g} M" if step >= 1e5 else f"{step:g}"
    )
    axes.grid(color="#dddddd", linewidth=0.6)
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False)
    return as_png(figure)


def as_png(figure: Figure) -> bytes:
    """A figure as the bytes of a file, without a date in it."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    return buffer.getvalue()


def lateral_places_m(network: QNetwork, config: TrainConfig) -> npt.NDArray[np.float64]:
    """Where the agents were, to the left, every few steps: (n,)."""
    simulation = Simulation(config.goal_world, config.contract(), validation_seeds(AGENTS))
    driver, places_m = GreedyDriver(network, config, simulation), []
    for _ in range(STEPS // EVERY):
        driver.drive(EVERY)
        places_m.append(simulation.y_m)
    return np.concatenate(places_m)


def draw_occupancy(network: QNetwork, config: TrainConfig) -> bytes:
    """Share of the time at each lateral place, as PNG."""
    places_m = lateral_places_m(network, config)
    figure = Figure(figsize=(8.0, 2.8), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    share = np.full(len(places_m), 100.0 / len(places_m))
    shares, _, _ = axes.hist(places_m, bins=BINS, weights=share, color=_VALIDATION, linewidth=0)
    axes.set_ylim(0.0, 1.3 * float(np.max(shares)))  # room for the legend above the bars
    axes.axhline(100.0 / BINS, color=_BLIND, linestyle="--", linewidth=1.0, label="even")
    axes.set_title(f"lateral occupancy in {config.goal.name}", loc="left", color=_INK)
    axes.set_xlabel("y, m to the left")
    axes.set_ylabel("% of the time")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="upper right")
    return as_png(figure)
