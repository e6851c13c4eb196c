"""What is near an agent in a field of upright white boxes: the common case, in vectors.

The same obstacles as `near.py` lists, but for rounding to float32, in phases over flat arrays, each
of which the compiler turns into vector instructions: the chunks in reach; how many obstacles each
has; one entry an obstacle; the entries' places and sizes; those that reach into the box are kept.
"""

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.chunks import BLOCK, PLACE, Row, chunk_key, column_key
from reflexarc_sim_bridge.compiled import compiled_inline, compiled_inner
from reflexarc_sim_bridge.layers import CHUNK_M
from reflexarc_sim_bridge.params import BOX_HALF_LENGTH, BOX_HALF_WIDTH, BOX_PAINT, BOX_X, BOX_Y
from reflexarc_sim_bridge.random_numbers import (
    advanced,
    between,
    first_half,
    mixed,
    number,
    second_half,
    uniform,
)

Floats32 = npt.NDArray[np.float32]

EIGHT = 8
"""Entries are written so many at a time: how many a chunk has, no branch foresees."""
WHITE = np.float32(0xFFFFFF)

_SPARE = 4
_DIAGONAL = math.sqrt(2.0)
"""What reaches so far along x and y reaches this much farther at most."""


class Entries(NamedTuple):
    """Scratch: chunks in reach, and one entry for each of their obstacles."""

    keys: npt.NDArray[np.uint64]
    """Key of each chunk: (chunks,)."""
    corner_x: npt.NDArray[np.float64]
    corner_y: npt.NDArray[np.float64]
    draws: npt.NDArray[np.float64]
    counts: npt.NDArray[np.int64]
    """Obstacles of each chunk: (chunks,)."""
    numbers: npt.NDArray[np.uint64]
    """Where each obstacle's random numbers begin: (entries,)."""
    x_m: Floats32
    """First of its chunk, then of itself, from the corner of the agent's cell: (entries,)."""
    y_m: Floats32
    half_length_m: Floats32
    half_width_m: Floats32
    kept: npt.NDArray[np.bool_]


@compiled_inner
def gather_upright_boxes(
    plane: Row,
    layer: Row,
    shape: Row,
    counts: npt.NDArray[np.float64],
    key: np.uint64,
    cell: npt.NDArray[np.int64],
    entries: Entries,
    boxes: Floats32,
) -> int:
    """List the boxes that reach into the box around an agent's cell; returns how many.

    Args:
        plane: row of `PLANE_DTYPE`.
        layer: row of `LAYER_DTYPE`.
        shape: row of `SHAPE_DTYPE`.
        counts: probability of at most so many in a chunk: (counts,).
        key: key of the layer.
        cell: the agent's: (2,).
        entries: scratch.
        boxes: filled, rows BOX_*: (5, capacity).
    """
    chunks = _chunks_in_reach(plane, layer, key, cell, entries)
    _count(counts, entries, chunks)
    end = _expand(entries, chunks)
    _draw(plane, shape, entries, end)
    return _keep(entries, end, boxes)


@compiled_inline
def chunks_between(low_m: float, high_m: float, side_m: float) -> tuple[int, int]:
    """First and last chunk of a stretch."""
    return math.floor(low_m / side_m), math.floor(high_m / side_m)


@compiled_inline
def is_beyond(x_m: float, length_m: float, y_m: float, width_m: float, farthest_m: float) -> bool:
    """Whether a chunk with its corner at (x, y) is farther from the agent's cell than so much.

    Both are `length` by `width`.
    """
    away_x, away_y = max(abs(x_m) - length_m, 0.0), max(abs(y_m) - width_m, 0.0)
    return away_x * away_x + away_y * away_y > farthest_m * farthest_m


@compiled_inline
def farthest_in_reach_m(plane: Row, layer: Row) -> float:
    """Farther from an agent's cell no chunk holds anything that matters."""
    reach_m: float = _DIAGONAL * layer.reach_m
    return float(max(plane.ahead_m, plane.behind_m)) + reach_m


@compiled_inline
def _chunks_in_reach(
    plane: Row, layer: Row, key: np.uint64, cell: npt.NDArray[np.int64], entries: Entries
) -> int:
    side_m, reach_m = plane.chunk_width_m, layer.reach_m
    first_i, last_i = chunks_between(
        -plane.behind_m - reach_m, CHUNK_M + plane.ahead_m + reach_m, CHUNK_M
    )
    first_j, last_j = chunks_between(
        -plane.aside_m - reach_m, side_m + plane.aside_m + reach_m, side_m
    )
    farthest_m, n = farthest_in_reach_m(plane, layer), 0
    for di in range(first_i, last_i + 1):
        column = column_key(key, cell[0] + di)
        for dj in range(first_j, last_j + 1):
            at, x_m, y_m = np.uintp(n), di * CHUNK_M, dj * side_m
            entries.keys[at] = chunk_key(column, cell[1] + dj, plane.across)
            entries.corner_x[at], entries.corner_y[at] = x_m, y_m
            n += not is_beyond(x_m, CHUNK_M, y_m, side_m, farthest_m)
    return n


@compiled_inline
def _count(counts: npt.NDArray[np.float64], entries: Entries, chunks: int) -> None:
    """Poisson: as many obstacles as there are counts whose probability the draw has passed.

    All chunks are compared at once, until none has so many.
    """
    keys, draws, found = entries.keys, entries.draws, entries.counts
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
def _expand(entries: Entries, chunks: int) -> int:
    """Begin an entry for every obstacle; returns how many."""
    numbers, x_m, y_m, end = entries.numbers, entries.x_m, entries.y_m, 0
    for c in range(chunks):
        key, x, y = (
            entries.keys[c],
            np.float32(entries.corner_x[c]),
            np.float32(entries.corner_y[c]),
        )
        for first in range(0, entries.counts[c], EIGHT):
            for k in range(first, first + EIGHT):
                at = np.uintp(end + k)
                numbers[at] = advanced(key, np.uint64(k) * BLOCK + PLACE)
                x_m[at], y_m[at] = x, y
        end += entries.counts[c]
    return end


@compiled_inline
def _draw(plane: Row, shape: Row, entries: Entries, end: int) -> None:
    """Places and sizes, and whether an obstacle reaches into the box."""
    back_m, front_m = -plane.behind_m, CHUNK_M + plane.ahead_m
    side_m = plane.chunk_width_m
    right_m, left_m = -plane.aside_m, side_m + plane.aside_m
    width_low, width_high = shape.size_low, shape.size_high
    length_low, length_high = shape.length_low, shape.length_high
    numbers, kept = entries.numbers, entries.kept
    xs, ys = entries.x_m, entries.y_m
    lengths, widths = entries.half_length_m, entries.half_width_m
    for k in range(end):
        place, size = mixed(numbers[k]), mixed(advanced(numbers[k], np.uint64(0)))
        x_m = first_half(place) * CHUNK_M + np.float64(xs[k])
        y_m = second_half(place) * side_m + np.float64(ys[k])
        half_width_m = 0.5 * between(width_low, width_high, first_half(size))
        half_length_m = 0.5 * between(length_low, length_high, second_half(size))
        xs[k], ys[k], lengths[k], widths[k] = x_m, y_m, half_length_m, half_width_m
        away_x = back_m - x_m if back_m - x_m > x_m - front_m else x_m - front_m
        away_y = right_m - y_m if right_m - y_m > y_m - left_m else y_m - left_m
        kept[k] = (away_x <= half_length_m) & (away_y <= half_width_m)


@compiled_inline
def _keep(entries: Entries, end: int, boxes: Floats32) -> int:
    """Copy the kept ones, written first and counted after; returns how many."""
    most, n = boxes.shape[1] - _SPARE, 0
    x_m, y_m, half_length_m = boxes[BOX_X], boxes[BOX_Y], boxes[BOX_HALF_LENGTH]
    half_width_m, paint = boxes[BOX_HALF_WIDTH], boxes[BOX_PAINT]
    for k in range(end):
        at = np.uintp(n)
        x_m[at], y_m[at] = entries.x_m[k], entries.y_m[k]
        half_length_m[at], half_width_m[at] = entries.half_length_m[k], entries.half_width_m[k]
        n += entries.kept[k] & (n < most)
    for k in range(n):
        paint[k] = WHITE
    return n
