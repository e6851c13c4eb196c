"""Drawing the boxes of a column of chunks from their seeds, in vectors, for a belt (`belt.py`)."""

import math

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import (
    BELT_X,
    BELT_Y,
    COS,
    HALF_LENGTH,
    HALF_WIDTH,
    SIN,
    Belt,
    Row,
)
from reflexarc_sim_bridge.arrays.workspace import EIGHT, Draws
from reflexarc_sim_bridge.native.decorators import compiled_disjoint, compiled_inline
from reflexarc_sim_bridge.native.splitmix64 import (
    advanced,
    between,
    first_half,
    mixed,
    number,
    second_half,
    uniform,
)
from reflexarc_sim_bridge.obstacles.keys import BLOCK, PLACE, chunk_key

CHUNK_BITS = 24
"""A place along x is so many bits of a chunk."""
TURN = 2.0**32
"""A place across is so many parts of the period."""


@compiled_inline
def place_boxes(
    across: int, counts: npt.NDArray[np.float64], column: np.uint64, draws: Draws
) -> int:
    """Write an entry of `draws` for every box of a column of chunks; returns how many."""
    for j in range(across):
        draws.keys[j] = chunk_key(column, j, across)
    _count(counts, across, draws.keys, draws.draws, draws.counts)
    end = 0
    for j in range(across):
        key, chunk = draws.keys[j], np.float64(j)
        for first in range(0, draws.counts[j], EIGHT):
            for k in range(first, first + EIGHT):
                at = np.uintp(end + k)
                draws.numbers[at] = advanced(key, np.uint64(k) * BLOCK + PLACE)
                draws.chunks[at] = chunk
        end += draws.counts[j]
    return end


@compiled_disjoint
def _count(
    counts: npt.NDArray[np.float64],
    chunks: int,
    keys: npt.NDArray[np.uint64],
    draws: npt.NDArray[np.float64],
    found: npt.NDArray[np.int64],
) -> None:
    """Poisson: as many boxes as there are counts whose probability the draw has passed.

    All chunks are compared at once, until none has so many.
    """
    for c in range(chunks):
        draws[c] = uniform(number(keys[c], np.uint64(0)))
        found[c] = 0
    for k in range(counts.size):
        probability, passed = counts[k], 0
        for c in range(chunks):
            found[c] += draws[c] >= probability
            passed += draws[c] >= probability
        if passed == 0:
            return


@compiled_inline
def draw_boxes(
    plane: Row, shape: Row, i: int, draws: Draws, belt: Belt, begun: int, end: int
) -> None:
    """Draw places and sizes of the boxes of column i: entries `begun` to `end` of a belt."""
    x, y = belt.places[BELT_X, begun:end], belt.places[BELT_Y, begun:end]
    half_length, half_width = belt.sizes[HALF_LENGTH, begun:end], belt.sizes[HALF_WIDTH, begun:end]
    numbers, chunks = draws.numbers, draws.chunks
    corner, per_chunk = i << CHUNK_BITS, TURN / plane.across
    width_low, width_high = shape.size_low, shape.size_high
    length_low, length_high = shape.length_low, shape.length_high
    for k in range(end - begun):
        place, size = mixed(numbers[k]), mixed(advanced(numbers[k], np.uint64(0)))
        x[k] = np.int32(corner + np.int64(first_half(place) * (1 << CHUNK_BITS)))
        y[k] = np.int32(np.int64((chunks[k] + second_half(place)) * per_chunk))
        half_width[k] = 0.5 * between(width_low, width_high, first_half(size))
        half_length[k] = 0.5 * between(length_low, length_high, second_half(size))


@compiled_inline
def turn_boxes(shape: Row, draws: Draws, belt: Belt, begun: int, end: int) -> None:
    """Draw the angles of the boxes at entries `begun` to `end` of a belt."""
    for k in range(end - begun):
        turn = second_half(mixed(advanced(draws.numbers[k], np.uint64(1))))
        turned_rad = between(shape.turned_low, shape.turned_high, turn)
        belt.sizes[COS, begun + k] = math.cos(turned_rad)
        belt.sizes[SIN, begun + k] = math.sin(turned_rad)
