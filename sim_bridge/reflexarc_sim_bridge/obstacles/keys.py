"""Keys of random numbers: all that a chunk, a layer or an agent draws follows from its key."""

import math

import numpy as np

from reflexarc_sim_bridge.arrays.layout import Row
from reflexarc_sim_bridge.native.decorators import compiled_inline
from reflexarc_sim_bridge.native.splitmix64 import joined, number

GENERATOR_VERSION = 2
"""Part of every key. Any change to what a seed means takes a new one."""

BLOCK = np.uint64(64)
"""Numbers of one obstacle. Number 0 of a chunk is its count; obstacle k has the numbers from
1 + 64k to 64 + 64k."""
PLACE, SIZE, KIND, OUTLINE, PAINT, PAINT_BLUE, MARK, CORNERS = map(np.uint64, range(1, 9))
"""What each number of an obstacle is for, from the beginning of its block."""

_VERSION = np.uint64(GENERATOR_VERSION)
_OBSTACLES, _AGENTS = np.uint64(0), np.uint64(1)
_S8, _S16 = np.uint64(8), np.uint64(16)


@compiled_inline
def layer_key(stream: int, seed: np.uint64, layer: int) -> np.uint64:
    """Key of a layer's random numbers."""
    own = (np.uint64(stream) << _S16) | (np.uint64(layer) << _S8) | _OBSTACLES
    return joined(joined(joined(np.uint64(0), _VERSION), seed), own)


@compiled_inline
def agent_number(stream: int, seed: np.uint64, lane: np.uint64, counter: np.uint64) -> np.uint64:
    """Random number of an agent: `counter` counts, `lane` tells agents of one seed apart."""
    own = (np.uint64(stream) << _S16) | _AGENTS
    return number(joined(joined(joined(joined(np.uint64(0), _VERSION), seed), own), lane), counter)


@compiled_inline
def chunks_between(low_m: float, high_m: float, side_m: float) -> tuple[int, int]:
    """Numbers of the chunks that hold the ends of an interval."""
    return math.floor(low_m / side_m), math.floor(high_m / side_m)


@compiled_inline
def column_key(key: np.uint64, i: int) -> np.uint64:
    """Key of all chunks with the same i."""
    return joined(key, np.uint64(i))


@compiled_inline
def chunk_key(column: np.uint64, j: int, across: int) -> np.uint64:
    """Key of chunk j of a column that has `across` chunks, or endlessly many (0)."""
    if across > 0 and not 0 <= j < across:  # a division that is seldom needed
        j %= across
    return joined(column, np.uint64(j))


@compiled_inline
def draw(plane: Row, state: Row) -> np.uint64:
    """The next random number of an agent."""
    bits = agent_number(plane.stream, state.seed, state.lane, state.draws)
    state.draws += np.uint64(1)
    return bits
