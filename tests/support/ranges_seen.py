"""Retinas of the reference field's eye from distances, by hand."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.arrays import Memories, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract

RAYS, RANGE_M = 16, 5.0
BEARINGS_RAD = np.radians([84.375 - 11.25 * ray for ray in range(RAYS)])


def seen(*ranges_m: Sequence[float] | npt.NDArray[np.floating]) -> RetinaBatch:
    """What agents see at these distances, one row of 16 for each: (n, 1, 1, 16, 1)."""
    shares = np.minimum(np.array(ranges_m, np.float64) / RANGE_M, 1.0)
    return np.round(255.0 * (1.0 - shares)).astype(np.uint8).reshape(-1, 1, 1, RAYS, 1)


def far_except(**near_m: float) -> RetinaBatch:
    """Nothing in sight but for rays named `ray7`, counted from the left."""
    ranges_m = np.full(RAYS, np.inf)
    for name, distance_m in near_m.items():
        ranges_m[int(name.removeprefix("ray"))] = distance_m
    return seen(ranges_m)


def unremembered(contract: PolicyContract, agents: int = 1) -> Memories:
    """The memories of agents that begin: (agents, size)."""
    return np.tile(np.array(contract.state.start_value, np.float32), (agents, 1))


def assorted(agents: int) -> RetinaBatch:
    """Retinas of any values."""
    generator = np.random.default_rng(7)
    return generator.integers(0, 256, (agents, 1, 1, RAYS, 1), dtype=np.uint8)
