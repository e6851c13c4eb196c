import math

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.simulation.scene import outlines_of_chunk
from reflexarc_sim_bridge.worlds.layers import CHUNK_M, Automaton
from reflexarc_sim_bridge.worlds.world import Edges, World
from support.slow_world import side_m

Cells = npt.NDArray[np.int64]


def full_cells(world: World, seed: int, columns: range, rows: range) -> Cells:
    """Which cells of a region are full: [x, y], from the outlines."""
    (layer,) = world.layers
    assert isinstance(layer, Automaton)
    count = layer.cells_per_chunk
    cells = np.zeros((len(columns) * count, len(rows) * count), np.int64)
    length_m, width_m = CHUNK_M / count, side_m(world) / count
    for i in columns:
        for j in rows:
            for outline in outlines_of_chunk(world, seed, i, j):
                low, high = outline.corners_m.min(axis=0), outline.corners_m.max(axis=0)
                x0, x1 = (round(v / length_m) - columns.start * count for v in (low[0], high[0]))
                y0, y1 = (round(v / width_m) - rows.start * count for v in (low[1], high[1]))
                assert x1 == x0 + 1
                cells[x0:x1, y0:y1] += 1
    assert cells.max() <= 1  # no cell is filled twice
    return cells


def smoothed(cells: Cells) -> Cells:
    """One smoothing of a torus, cell by cell."""
    neighbours = sum(
        np.roll(cells, (dx, dy), (0, 1)) for dx in (-1, 0, 1) for dy in (-1, 0, 1) if dx or dy
    )
    return np.where(neighbours >= 5, 1, np.where(neighbours <= 3, 0, cells))


@pytest.mark.parametrize(
    ("count", "fill", "smoothings"), [(10, 0.3, 2), (16, 0.45, 4), (7, 0.4, 1)]
)
def test_cells_are_those_of_one_automaton_over_the_whole_plane(
    count: int, fill: float, smoothings: int
) -> None:
    """Against the direct automaton, over 8 by 8 chunks: their borders agree."""
    worlds = [
        World("cells", layers=(Automaton(count, fill, n),), edges=Edges.UNBOUNDED)
        for n in (0, smoothings)
    ]
    plain, found = (full_cells(world, 6, range(-4, 4), range(-4, 4)) for world in worlds)
    share = plain.mean()
    assert share == pytest.approx(fill, abs=4 * math.sqrt(fill * (1 - fill) / plain.size))
    for _ in range(smoothings):
        plain = smoothed(plain)
    inner = slice(smoothings, -smoothings)
    np.testing.assert_array_equal(found[inner, inner], plain[inner, inner])
    assert 0.0 < found.mean() < 1.0


def test_a_periodic_automaton_is_smoothed_across_its_seam() -> None:
    worlds = [World("cells", width_m=10.0, layers=(Automaton(10, 0.4, n),)) for n in (0, 3)]
    plain, found = (full_cells(world, 6, range(-2, 4), range(4)) for world in worlds)
    for _ in range(3):
        plain = smoothed(plain)  # a torus across, which is right; along, the first rows are wrong
    np.testing.assert_array_equal(found[3:-3], plain[3:-3])
