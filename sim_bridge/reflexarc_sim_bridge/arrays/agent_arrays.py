"""Agents that are nowhere yet, with room for all that can come near them."""

import math
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract
from reflexarc_sim_bridge.arrays.layout import (
    AGENT_DTYPE,
    BOX,
    BOX_ROWS,
    CURVE,
    DISC,
    DISC_ROWS,
    OPEN,
    POLYGON,
    SIDE_ROWS,
    TURNED_BOX,
    TURNED_ROWS,
    Agents,
    WorldTables,
)
from reflexarc_sim_bridge.native.intrinsics import LANES, whole
from reflexarc_sim_bridge.worlds.layers import CHUNK_M
from reflexarc_sim_bridge.worlds.outlines import CURVE_CORNERS

_CACHE_LINE = 64


def agents_at_zero(
    seeds: npt.NDArray[np.uint64],
    tables: WorldTables,
    room: WorldTables,
    contract: PolicyContract,
) -> Agents:
    """Agents that are nowhere yet; `kernel.advance` puts them into their worlds.

    Args:
        seeds: one an agent: (n,).
        tables: one world for all, or one for each agent.
        room: the fullest of the worlds, which say how much room to make.
        contract: what the agents see and do.
    """
    spec, n, layers = contract.retina, len(seeds), tables.layers.shape[1]
    state = np.zeros(n, AGENT_DTYPE)
    state["seed"], state["lane"] = seeds, _lanes(seeds)
    state["world"] = np.arange(n) if len(tables.planes) > 1 else 0
    boxes, turned, discs, sides = _near_capacities(room)
    columns, belt = np.max([_belt_capacity(room, w) for w in range(len(room.planes))], axis=0)
    latency_steps = int(tables.planes["latency_steps"][0])
    return Agents(
        state,
        np.zeros((n, layers, 2), np.int64),
        np.zeros((n, layers, 4), np.int64),
        _zeros((n, layers, BOX_ROWS, boxes), np.float32),
        _zeros((n, layers, TURNED_ROWS, turned), np.float32),
        _zeros((n, layers, DISC_ROWS, discs), np.float32),
        _zeros((n, layers, SIDE_ROWS, sides), np.float32),
        _zeros((n, layers, 2, belt), np.int32),
        _zeros((n, layers, 4, belt), np.float32),
        np.zeros((n, layers, columns), np.int64),
        np.zeros((n, latency_steps + 1, spec.size), np.uint8),
        np.zeros((n, spec.frames * spec.size), np.uint8),
    )


def _near_capacities(tables: WorldTables) -> list[int]:
    """Columns of the four near lists: enough for any layer of any world."""
    needs = np.zeros(4, np.int64)
    for w, plane in enumerate(tables.planes):
        for number in range(int(plane["layers"])):
            needs = np.maximum(needs, _needs(tables, w, number))
    return [whole(int(need) + 1 + LANES) if need else LANES for need in needs]


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
    return columns, whole(max((_room_for(mean) for mean in means), default=0))


def _zeros(shape: tuple[int, ...], dtype: type[np.generic]) -> npt.NDArray[Any]:
    """An array that begins where a line of the cache does: no vector of it is in two of them."""
    size = math.prod(shape) * np.dtype(dtype).itemsize
    memory = np.zeros(size + _CACHE_LINE, np.uint8)
    start = -memory.ctypes.data % _CACHE_LINE
    return memory[start : start + size].view(dtype).reshape(shape)


def _room_for(mean: float) -> int:
    """The mean of a Poisson count and ten standard deviations."""
    return math.ceil(mean + 10 * math.sqrt(mean) + 20)


def _needs(tables: WorldTables, w: int, number: int) -> npt.NDArray[np.int64]:
    """Most boxes, turned boxes, discs and sides near an agent: mean and ten standard deviations."""
    plane, layer = tables.planes[w], tables.layers[w, number]
    reach_m = 2 * layer["reach_m"]
    length_m = CHUNK_M + plane["ahead_m"] + plane["behind_m"] + reach_m
    width_m = plane["chunk_width_m"] + 2 * plane["aside_m"] + reach_m
    chunks = math.ceil(length_m / CHUNK_M + 1) * math.ceil(width_m / plane["chunk_width_m"] + 1)
    match int(layer["kind"]):
        case 1:  # gates: pieces of walls
            return np.array([4 * chunks, 0, 0, 0])
        case 2:  # corridor: two walls of four sides
            return np.array([0, 0, 0, 8 * math.ceil(length_m / CHUNK_M + 1)])
        case 3:  # automaton: every other cell at most begins a run
            return np.array([chunks * layer["cells"] * (layer["cells"] + 1) // 2, 0, 0, 0])
    counts = tables.counts[w, number]
    densest = float((1.0 - counts).sum(axis=1).max()) / (CHUNK_M * plane["chunk_width_m"])
    mean = densest * _crowding(plane, layer) * length_m * width_m
    most = _room_for(mean)
    corners = [_corners_of(shape) for shape in tables.shapes[w, number, : int(layer["shapes"])]]
    kinds = {int(shape["kind"]) for shape in tables.shapes[w, number, : int(layer["shapes"])]}
    listed = [most * (kind in kinds) for kind in (BOX, TURNED_BOX, DISC)]
    return np.array([*listed, most * max(corners)])


def _crowding(plane: Any, layer: Any) -> float:
    """How much denser centres lie than they are drawn: with open edges, pushed inwards.

    More than fourfold they are in a strip that is narrower than what is near anyway. Where it is
    just that, a family's widths between its ends may have 5 % more of them than at these.
    """
    if plane["edges"] != OPEN:
        return 1.0
    room_m = plane["width_m"] - layer["reach_m"]
    return float(plane["width_m"] / max(room_m, plane["width_m"] / 4))


def _corners_of(shape: Any) -> int:
    by_kind = {POLYGON: int(shape["corners_high"]), CURVE: CURVE_CORNERS}
    return by_kind.get(int(shape["kind"]), 0)


def _lanes(seeds: npt.NDArray[np.uint64]) -> npt.NDArray[np.uint64]:
    """How many earlier agents have the same seed: (n,)."""
    seen: dict[int, int] = {}
    lanes = np.zeros(len(seeds), np.uint64)
    for i, seed in enumerate(seeds.tolist()):
        lanes[i] = seen.setdefault(seed, 0)
        seen[seed] += 1
    return lanes
