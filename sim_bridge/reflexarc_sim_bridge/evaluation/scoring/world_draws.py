"""Bootstrap draws of worlds, as counts: how often each world is in each draw.

The world of one index has one seed in all cells, so that cells of one kind (the field, dim, noisy)
hold the same obstacles: an index is drawn once for all cells, and for limits and contenders alike.
The first row is no draw: every world once.
"""

import numpy as np

from reflexarc_sim_bridge.evaluation.metrics.track import Floats

DRAWS = 2000
_SEED = 20_250_105


def world_draws(worlds: int, draws: int = DRAWS) -> Floats:
    """Counts: (1 + draws, worlds), each row with the sum `worlds`."""
    generator = np.random.default_rng(_SEED)
    drawn = generator.multinomial(worlds, np.full(worlds, 1.0 / worlds), draws)
    return np.concatenate([np.ones((1, worlds)), drawn.astype(np.float64)])


def seed_draws(
    seeds: int, draws: int = DRAWS, stream: int = 0
) -> "np.ndarray[tuple[int, int], np.dtype[np.int64]]":
    """Indices of training seeds: (1 + draws, seeds); the first row is every seed once.

    Seeds of two presets have nothing to do with each other: each preset has a stream of its own.
    """
    generator = np.random.default_rng(_SEED + 1 + stream)
    drawn = generator.integers(0, seeds, (draws, seeds))
    return np.concatenate([np.arange(seeds)[np.newaxis], drawn])
