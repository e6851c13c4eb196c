"""Arrays for new agents, long enough for all obstacles that can be near them."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.arrays.layout import (
    AGENT_DTYPE,
    BOX_ROWS,
    DISC_ROWS,
    MARK_LAYERS,
    MARK_LISTS,
    SIDE_ROWS,
    TURNED_ROWS,
    Agents,
    WorldTables,
)
from reflexarc_sim_bridge.native.intrinsics import LANES, whole
from reflexarc_sim_bridge.worlds.grid import CHUNK_M
from reflexarc_sim_bridge.worlds.kinds.scatter import most_of_poisson

_MOST_NEAR = "most_boxes", "most_turned", "most_discs", "most_sides"
_CACHE_LINE = 64
MOST_STRIPED = (1 << 24) // (MARK_LISTS * MARK_LAYERS) - 1
"""Marks that tell so many obstacles apart are exact in float32."""


def agents_at_zero(
    seeds: npt.NDArray[np.uint64],
    tables: WorldTables,
    room: WorldTables,
    contract: PolicyContract,
) -> Agents:
    """Agents that have no place yet: the task PLACE of a step puts them into their worlds.

    Args:
        seeds: one an agent: (n,).
        tables: one world for all, or one for each agent.
        room: tables of the worlds that need most memory; the lists get the room that these need.
        contract: what the agents see and do.
    """
    spec, n, layers = contract.retina, len(seeds), tables.layers.shape[1]
    state = np.zeros(n, AGENT_DTYPE)
    state["seed"], state["lane"] = seeds, _lanes(seeds)
    state["world"] = np.arange(n) if len(tables.planes) > 1 else 0
    boxes, turned, discs, sides = _near_capacities(room)
    surfaces = _surface_rows(room, max(boxes, turned, discs))
    columns, belt = np.max([_belt_capacity(room, w) for w in range(len(room.planes))], axis=0)
    latency_steps = int(tables.planes["latency_steps"][0])
    return Agents(
        state,
        np.zeros((n, layers, 2), np.int64),
        np.zeros((n, layers, 4), np.int64),
        _zeros((n, layers, BOX_ROWS + surfaces, boxes), np.float32),
        _zeros((n, layers, TURNED_ROWS + surfaces, turned), np.float32),
        _zeros((n, layers, DISC_ROWS + surfaces, discs), np.float32),
        _zeros((n, layers, SIDE_ROWS, sides), np.float32),
        _zeros((n, layers, 2, belt), np.int32),
        _zeros((n, layers, 4, belt), np.float32),
        np.zeros((n, layers, columns), np.int64),
        np.zeros((n, latency_steps + 1, spec.size), np.uint8),
        np.zeros((n, spec.frames * spec.size), np.uint8),
    )


def _near_capacities(tables: WorldTables) -> list[int]:
    """Columns of the four near lists: enough for any layer of any world."""
    needs = [int(tables.layers[name].max()) for name in _MOST_NEAR]
    # What writes whole vectors may write so many more.
    return [whole(need + 1 + LANES) if need else LANES for need in needs]


def _surface_rows(tables: WorldTables, capacity: int) -> int:
    """How many more rows the near lists have for striped surfaces: see `obstacles/stripes.py`.

    Raises:
        WorldError: a list is too long for its entries to be told apart in float32.
    """
    if not (tables.layers["stripes_m"] > 0.0).any():
        return 0
    if capacity > MOST_STRIPED:
        raise WorldError(
            f"world: expected at most {MOST_STRIPED} striped obstacles of a kind near an agent, "
            f"got room for {capacity}; take fewer, a shorter range of the eye, or no stripes"
        )
    return 1


def _belt_capacity(tables: WorldTables, w: int) -> tuple[int, int]:
    """Columns of chunks of a belt in a world, and boxes that it has room for."""
    plane, layers = tables.planes[w], tables.layers[w]
    reach_m = 2 * float(layers["reach_m"].max())
    length_m = CHUNK_M + float(plane["ahead_m"] + plane["behind_m"]) + reach_m
    columns = math.ceil(length_m / CHUNK_M) + 1
    means = [
        columns * int(plane["across"]) * float((1.0 - tables.counts[w, number, 0]).sum())
        for number in np.flatnonzero(layers["has_belt"])
    ]
    return columns, whole(max((most_of_poisson(mean) for mean in means), default=0))


def _zeros(shape: tuple[int, ...], dtype: type[np.generic]) -> npt.NDArray[Any]:
    """Zeros that begin where a line of the cache does, so that no vector crosses two lines."""
    size = math.prod(shape) * np.dtype(dtype).itemsize
    memory = np.zeros(size + _CACHE_LINE, np.uint8)
    start = -memory.ctypes.data % _CACHE_LINE
    return memory[start : start + size].view(dtype).reshape(shape)


def _lanes(seeds: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """How many earlier agents have the same seed: (n,)."""
    seen: dict[int, int] = {}
    lanes = np.zeros(len(seeds), np.uint64)
    for i, seed in enumerate(seeds.tolist()):
        lanes[i] = seen.setdefault(seed, 0)
        seen[seed] += 1
    return lanes
