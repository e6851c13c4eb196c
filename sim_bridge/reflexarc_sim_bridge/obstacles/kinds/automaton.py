"""Cells that are full at random, then smoothed by a cellular automaton, a chunk at a time.

A row of cells is a number of 64 bits, one bit a cell, so that one operation treats a whole row.
The neighbours of all cells of a row are counted at once, with adders made of bit operations. A
chunk is computed with a margin of as many cells as there are smoothings, so that no cell beyond it
has any effect: neighbouring chunks agree about their borders. A run of full cells in a row is one
box.
"""

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.arrays.layout import BOX, Params, Table, WorldTables
from reflexarc_sim_bridge.arrays.workspace import Workspace
from reflexarc_sim_bridge.native.decorators import compiled, compiled_called, compiled_inner
from reflexarc_sim_bridge.native.splitmix64 import joined, number, uniform
from reflexarc_sim_bridge.obstacles.chunks import Chunk, draw_chunk, gather_chunks
from reflexarc_sim_bridge.obstacles.obstacle import Obstacle, paint_of
from reflexarc_sim_bridge.worlds.grid import CHUNK_M

_ONE = np.uint64(1)


@compiled_called
def gather(params: Params, work: Workspace, i: int, number: int, x: int, y: int) -> None:
    """List the runs of full cells near an agent: see `chunks.gather_chunks`."""
    gather_chunks(params, work, i, number, x, y, _count, _obstacle_at)


@compiled
def draw(
    world: WorldTables,
    seed: np.uint64,
    number: int,
    i: int,
    j: int,
    cells: npt.NDArray[np.uint64],
    rows: Table,
) -> int:
    """Draw the runs of full cells of a chunk: see `chunks.draw_chunk`."""
    return draw_chunk(world, seed, number, i, j, cells, rows, _count, _obstacle_at)


@compiled_inner
def _count(chunk: Chunk) -> int:
    layer, across = chunk.layer, chunk.plane.across
    fill, smoothings = layer.fill, layer.smoothings
    _fill_cells(
        chunk.layer_key, layer.cells, fill, smoothings, chunk.i, chunk.j, across, chunk.cells
    )
    return int(_run_count(chunk.cells, layer.cells))


@compiled_inner
def _obstacle_at(chunk: Chunk, index: int) -> Obstacle:
    """Run `index` of the full cells that `_count` has found."""
    plane, layer = chunk.plane, chunk.layer
    row, first, last = _find_run(chunk.cells, layer.cells, index)
    length_m, width_m = CHUNK_M / layer.cells, plane.chunk_width_m / layer.cells
    half_m, y_m = 0.5 * (last + 1 - first) * width_m, 0.5 * (first + last + 1) * width_m
    x_m, half_length_m = (row + 0.5) * length_m, 0.5 * length_m
    paint = paint_of(layer, chunk.key, np.uint64(index))
    return Obstacle(BOX, x_m, y_m, half_length_m, half_m, 0.0, 4, 0.0, np.uint64(0), paint)


@compiled_inner
def _fill_cells(
    key: np.uint64,
    count: int,
    fill: float,
    smoothings: int,
    i: int,
    j: int,
    across: int,
    cells: npt.NDArray[np.uint64],
) -> None:
    """Which cells of a chunk are full.

    Args:
        key: key of the layer.
        count: cells along a side of a chunk.
        fill: share that is full before smoothing.
        smoothings: how often it is smoothed.
        i: the chunk, along x.
        j: the chunk, along y.
        across: chunks from side to side, 0 where there are no sides.
        cells: filled; row r holds the r-th x, its bit b the b-th y: (MAX_ROWS,).
    """
    margin = smoothings
    rows = count + 2 * margin
    for row in range(rows):
        cells[row] = _random_row(
            key, fill, i * count + row - margin, j * count - margin, rows, across * count
        )
    for _ in range(smoothings):
        _smooth(cells, rows)
    inner = (_ONE << np.uint64(count)) - _ONE
    for row in range(count):
        cells[row] = (cells[row + margin] >> np.uint64(margin)) & inner


@compiled_inner
def _run_count(cells: npt.NDArray[np.uint64], count: int) -> int:
    """How many rows of neighbouring full cells a chunk has."""
    runs = 0
    for row in range(count):
        begins = cells[row] & ~(cells[row] << _ONE)
        while begins != np.uint64(0):
            begins &= begins - _ONE
            runs += 1
    return runs


@compiled_inner
def _find_run(cells: npt.NDArray[np.uint64], count: int, index: int) -> tuple[int, int, int]:
    """Row, first and last cell of run `index`."""
    runs = 0
    for row in range(count):
        bit = 0
        while bit < count:
            first = bit
            while bit < count and (cells[row] >> np.uint64(bit)) & _ONE:
                bit += 1
            if bit > first:
                if runs == index:
                    return row, first, bit - 1
                runs += 1
            bit += 1
    return 0, 0, -1


@compiled_inner
def _random_row(key: np.uint64, fill: float, x: int, y: int, width: int, period: int) -> np.uint64:
    row, bits = joined(key, np.uint64(x)), np.uint64(0)
    for bit in range(width):
        cell = (y + bit) % period if period > 0 else y + bit
        if uniform(number(row, np.uint64(cell))) < fill:
            bits |= _ONE << np.uint64(bit)
    return bits


@compiled_inner
def _smooth(cells: npt.NDArray[np.uint64], rows: int) -> None:
    above = np.uint64(0)
    for row in range(rows):
        here = cells[row]
        below = cells[row + 1] if row + 1 < rows else np.uint64(0)
        cells[row] = _smoothed(above, here, below)
        above = here


@compiled_inner
def _smoothed(above: np.uint64, here: np.uint64, below: np.uint64) -> np.uint64:
    """Full with five neighbours or more, empty with three or fewer, else as it is."""
    ones, twos, fours, eights = np.uint64(0), np.uint64(0), np.uint64(0), np.uint64(0)
    for row in (above, below):
        for neighbour in (row << _ONE, row, row >> _ONE):
            ones, twos, fours, eights = _counted(ones, twos, fours, eights, neighbour)
    for neighbour in (here << _ONE, here >> _ONE):
        ones, twos, fours, eights = _counted(ones, twos, fours, eights, neighbour)
    four_or_more = fours | eights
    four = fours & ~twos & ~ones & ~eights
    return (four_or_more & ~four) | (four & here)


@compiled_inner
def _counted(
    ones: np.uint64, twos: np.uint64, fours: np.uint64, eights: np.uint64, bits: np.uint64
) -> tuple[np.uint64, np.uint64, np.uint64, np.uint64]:
    """Add one bit to the four-bit count of each cell."""
    carry = ones & bits
    ones ^= bits
    carry_2 = twos & carry
    twos ^= carry
    eights ^= fours & carry_2
    fours ^= carry_2
    return ones, twos, fours, eights
