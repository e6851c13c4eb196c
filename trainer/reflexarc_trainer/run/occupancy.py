"""Where across the world a policy drives: a histogram of lateral places, as a picture.

Where cover is the same everywhere, so is a policy's that neither hugs an edge nor shuns one. Each
agent drives greedily in a validation world of its own.
"""

import numpy as np
import numpy.typing as npt
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.seeds import validation_seeds
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.q_network import QNetwork
from reflexarc_trainer.run.plots import as_png
from reflexarc_trainer.run.validation import GreedyDriver

AGENTS = 256
STEPS = 200
EVERY = 10
"""Steps between two looks at where an agent is: a metre on, at the usual speed."""
BINS = 40

_BAR, _EVEN, _INK = "#0b6e4f", "#a23b3b", "#333333"


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
    shares, _, _ = axes.hist(places_m, bins=BINS, weights=share, color=_BAR, linewidth=0)
    axes.set_ylim(0.0, 1.3 * float(np.max(shares)))  # room for the legend above the bars
    axes.axhline(100.0 / BINS, color=_EVEN, linestyle="--", linewidth=1.0, label="even")
    axes.set_title(f"lateral occupancy in {config.goal.name}", loc="left", color=_INK)
    axes.set_xlabel("y, m to the left")
    axes.set_ylabel("% of the time")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="upper right")
    return as_png(figure)
