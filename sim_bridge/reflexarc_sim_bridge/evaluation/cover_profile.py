"""The share of each lateral bin of a world that obstacles cover, measured without an agent.

Points are drawn evenly: columns at random x, and in each column one point in every bin across. The
bins divide the width of the world; in a corridor, the room between its walls. Every
seed is an independent sample; errors are standard errors over them.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_sim_bridge.arrays.world_tables import world_tables
from reflexarc_sim_bridge.evaluation.effort import effort_of
from reflexarc_sim_bridge.native.cache import prepare
from reflexarc_sim_bridge.native.decorators import compiled
from reflexarc_sim_bridge.obstacles.keys import layer_key
from reflexarc_sim_bridge.obstacles.kinds.corridor import corridor_middle_m
from reflexarc_sim_bridge.simulation.covered_places import covered
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.world import World, WorldSource

BINS = 40

_LENGTH_M = 10_000.0
_FIRST_COLUMNS, _MOST_COLUMNS = 64, 1024
_SHARED_M = 500.0
"""Up to this width places lie so near each other that they share the obstacles that are drawn for
them. In a wider world every place costs as much as a column of a narrow one: fewer are looked at,
and the errors say so. (At 10 km the same number would take minutes.)"""
_WANTED_ERROR = 0.01
_SIGHT_M = 0.1
"""Obstacles within sight are drawn for every place; of the reference's 5 m most are in vain."""
_WALL_MARGIN_M = 0.1
"""Largest distance between the straight pieces of a wall and its curve."""
_RANDOM_SEED = 20_250_102

Floats = npt.NDArray[np.float64]
Progress = Callable[[int, int], None]
"""Called with what is done, and how much there is in all."""


@dataclass(frozen=True)
class CoverProfile:
    """Cover across a world, right to left."""

    width_m: float
    """From side to side, or from wall to wall; the mean over seeds where they differ."""
    cover: Floats
    """Share of each bin that obstacles cover: (bins,)."""
    deviation: Floats
    """Cover of each bin ÷ mean cover − 1: (bins,); 0 where nothing is covered anywhere."""
    error: Floats
    """Standard error of each deviation: (bins,)."""

    @property
    def mean(self) -> float:
        """Mean cover."""
        return float(self.cover.mean())

    @property
    def lateral_m(self) -> Floats:
        """Middles of the bins, from the right side on: (bins,)."""
        return (np.arange(len(self.cover)) + 0.5) / len(self.cover) * self.width_m


def measure_profile(source: WorldSource, seeds: Sequence[int], progress: Progress) -> CoverProfile:
    """Measure the profile of a world, or of a family over its seeds.

    A first, small sample says how many columns it takes to know the deviations to 1 %.

    Args:
        source: the world.
        seeds: two or more.
        progress: called with the number of seeds that are done, and of all.
    """
    generator = np.random.default_rng(_RANDOM_SEED)
    worlds = [source.drawn(seed) for seed in seeds]
    least, most = columns_allowed(source, len(seeds))
    first = [_shares(w, s, least, generator) for w, s in zip(worlds, seeds, strict=True)]
    columns, shares = _columns_for(float(np.mean(first)), len(seeds), least, most), []
    for done, (world, seed) in enumerate(zip(worlds, seeds, strict=True), start=1):
        shares.append(_shares(world, seed, columns, generator))
        progress(done, len(seeds))
    width_m = float(np.mean([_room_m(world) for world in worlds]))
    return CoverProfile(width_m, np.mean(shares, axis=0), *_deviations(np.array(shares)))


def columns_allowed(source: WorldSource, seeds: int) -> tuple[int, int]:
    """How many columns of each seed are looked at, at least and at most."""
    fullest = source.fullest
    few = min(1.0, _SHARED_M / max(_room_m(world) for world in fullest))
    efforts = [effort_of(world, short_sighted(), BINS) for world in fullest]
    allowed = min(effort.most_columns(seeds) for effort in efforts)
    most = math.ceil(min(few * _MOST_COLUMNS, allowed))
    return min(math.ceil(few * _FIRST_COLUMNS), math.ceil(most / 8)), most


def are_covered(world: World, seed: int, x_m: Floats, y_m: Floats) -> npt.NDArray[np.bool_]:
    """Which points lie within obstacles or walls, at the start.

    Args:
        world: which world.
        seed: which of its variants.
        x_m: (n,).
        y_m: (n,).
    """
    pointlike = replace(world, chassis=replace(world.chassis, radius_m=0.0))
    return covered(pointlike, short_sighted(), seed, np.stack([x_m, y_m], axis=1))


def right_side_m(world: World, seed: int, x_m: Floats) -> Floats:
    """Where the bins begin at each x: at the right side, or just left of the right wall: (n,)."""
    if world.corridor is None:
        return np.zeros(len(x_m))
    prepare()
    tables = world_tables([world], reference_contract())
    number = int(tables.planes[0]["corridor"])
    walls = tables.layers[0, number]
    key = np.uint64(_layer_key(world.stream, np.uint64(seed), number))
    middles_m = [corridor_middle_m(walls, key, x) for x in x_m.tolist()]
    return np.array(middles_m) - _room_m(world) / 2


def ratio(parts: Floats, wholes: Floats) -> tuple[Floats, Floats]:
    """Ratio of the sums of parts to that of wholes, and its standard error.

    Linearised (Cochran, "Sampling Techniques", 1977, section 6.4): the rows are independent.

    Args:
        parts: (samples, columns).
        wholes: (samples,), with a sum above 0.
    """
    ratios: Floats = parts.sum(axis=0) / wholes.sum()
    rests, n = parts - ratios * wholes[:, np.newaxis], len(wholes)
    errors: Floats = np.sqrt((rests**2).sum(axis=0) * n / max(n - 1, 1)) / wholes.sum()
    return ratios, errors


def short_sighted() -> PolicyContract:
    """An agent that sees next to nothing: what is farther than that covers no place."""
    contract = reference_contract()
    return replace(contract, retina=replace(contract.retina, range_m=_SIGHT_M))


def _shares(world: World, seed: int, columns: int, generator: np.random.Generator) -> Floats:
    """Share of the points of each bin that are covered: (bins,)."""
    x_m = generator.uniform(0.0, _LENGTH_M, columns)
    across = (np.arange(BINS) + generator.random((columns, BINS))) / BINS
    y_m = right_side_m(world, seed, x_m)[:, np.newaxis] + across * _room_m(world)
    is_covered = are_covered(world, seed, np.repeat(x_m, BINS), y_m.ravel())
    share: Floats = is_covered.reshape(columns, BINS).mean(axis=0)
    return share


def _columns_for(cover: float, seeds: int, least: int, most: int) -> int:
    """Columns a seed for the wanted error of a deviation, √((1 − c) / (c n)) for n columns."""
    if cover == 0.0:
        return least
    columns = (1.0 - cover) / cover / _WANTED_ERROR**2 / seeds
    return int(np.clip(columns, least, most))


def _deviations(shares: Floats) -> tuple[Floats, Floats]:
    """Deviation of each bin from the mean, and its standard error; `shares` is (seeds, bins)."""
    wholes = shares.mean(axis=1)
    if not wholes.any():
        return np.zeros(shares.shape[1]), np.zeros(shares.shape[1])
    ratios, errors = ratio(shares, wholes)
    return ratios - 1.0, errors


def _room_m(world: World) -> float:
    """Width of all bins together."""
    if world.corridor is None:
        return world.width_m
    return world.corridor.width_m - 2 * _WALL_MARGIN_M


@compiled
def _layer_key(stream: int, seed: np.uint64, number: int) -> np.uint64:
    return layer_key(stream, seed, number)
