import dataclasses
import hashlib
import itertools
import math

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_sim_bridge.arrays.layout import BOXES, DISCS
from reflexarc_sim_bridge.arrays.world_tables import world_tables
from reflexarc_sim_bridge.simulation.scene import Outline, outlines_of_chunk
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import CHUNK_M, Automaton, Gates, Scatter
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles, Shape
from reflexarc_sim_bridge.worlds.world import Edges, World
from support.drawn_worlds import TURNING
from support.slow_geometry import Floats, area_m2

PLAIN = World("plain")
SPECKS = Rectangles(width_m=(0.01, 0.02), length_m=(0.03, 0.05))
"""So small that no start is refused: what lies around the agents is an even sample."""
WORLDS = {
    "rectangles": PLAIN,
    "mixed": World(
        "m", layers=(Scatter(0.3, (Rectangles(turned_rad=(0.0, 3.0)), Discs(), Curves())),)
    ),
    "thinned": World("t", layers=(Scatter(0.6, (Polygons(),), gap_m=1.0),)),
    "gates": World("g", layers=(Gates(spacing_m=2.5),)),
    "automaton": World("a", layers=(Automaton(fill=0.45),)),
    "open": World("o", edges=Edges.OPEN),
}


def digest(outlines: list[Outline]) -> str:
    rows = [np.append(o.corners_m.ravel(), (o.x_m, o.y_m, o.radius_m, *o.colour)) for o in outlines]
    return hashlib.sha256(b"".join(row.tobytes() for row in rows)).hexdigest()


@pytest.mark.parametrize("name", WORLDS)
def test_chunks_asked_for_in_any_order_are_the_same(name: str) -> None:
    places = list(itertools.product(range(-6, 6), range(8)))
    forwards = {at: digest(outlines_of_chunk(WORLDS[name], 3, *at)) for at in places}
    np.random.default_rng(0).shuffle(places)
    shuffled = {at: digest(outlines_of_chunk(WORLDS[name], 3, *at)) for at in places}
    assert forwards == shuffled
    assert len(set(forwards.values())) > 30


def test_the_reference_world_never_changes() -> None:
    # A change here is a new GENERATOR_VERSION and a new reference field.
    places = itertools.product((0, 2**64 - 1), (-1, 0, 9), (0, 7))
    found = "".join(digest(outlines_of_chunk(PLAIN, *place)) for place in places)
    assert (
        hashlib.sha256(found.encode()).hexdigest()
        == "66f8d247a869bdf4b0ff9b03aeb4654ecec2c4c7c5ece85c67959b264cfe12fb"
    )


def test_seed_chunk_stream_and_layer_each_make_another_world() -> None:
    dense = dataclasses.replace(PLAIN, layers=(Scatter(2.0),))
    other = dataclasses.replace(dense, stream=1)
    keys = itertools.product((dense, other), (0, 1, 2**63), (-1, 0, 1), (0, 1))
    found = {digest(outlines_of_chunk(*key)) for key in keys}
    twice = dataclasses.replace(PLAIN, layers=(Scatter(0.8), Scatter(0.8)))
    by_layer = [{o.x_m for o in outlines_of_chunk(twice, 1, 0, 0) if o.layer == k} for k in (0, 1)]
    assert len(found) == 36
    assert by_layer[0].isdisjoint(by_layer[1])


@pytest.mark.parametrize("name", ["rectangles", "mixed", "thinned", "gates", "automaton"])
def test_a_periodic_world_repeats_across(name: str) -> None:
    for i, j in ((0, 0), (5, 7), (-4, 3)):
        here = outlines_of_chunk(WORLDS[name], 9, i, j)
        for period in (-2, 1):
            there = outlines_of_chunk(WORLDS[name], 9, i, j + 8 * period)
            assert len(there) == len(here)
            for near, far in zip(here, there, strict=True):
                assert far.y_m - near.y_m == pytest.approx(20.0 * period)
                assert (far.x_m, far.radius_m, far.colour) == (near.x_m, near.radius_m, near.colour)


def test_an_obstacle_belongs_to_the_chunk_of_its_centre() -> None:
    discs = dataclasses.replace(PLAIN, layers=(Scatter(shapes=(Discs(),)),), width_m=22.0)
    side_m = 22.0 / 9
    for i, j in ((-3, 0), (0, 8), (1_000_000, 4)):
        for outline in outlines_of_chunk(discs, 1, i, j):
            assert i * CHUNK_M <= outline.x_m <= (i + 1) * CHUNK_M
            assert j * side_m <= outline.y_m <= (j + 1) * side_m


# Statistics over many worlds: what 4,096 agents of different seeds have around them


def around(
    layer: Scatter, edges: Edges = Edges.PERIODIC
) -> tuple[Simulation, Floats, npt.NDArray[np.int64]]:
    """Boxes and discs within 5 m of the agents' cells, as rows x, y, sizes, and whose they are."""
    contract = PolicyContract(retina=RetinaSpec(rays=2, range_m=5.0), actions=TURNING)
    world = World("sample", width_m=50.0, layers=(layer,), edges=edges)
    simulation = Simulation(world, contract, np.arange(4096, dtype=np.uint64))
    agents, found, whose = simulation.params.agents, [], []
    for kind, lists in ((BOXES, agents.boxes), (DISCS, agents.discs)):
        for agent, count in enumerate(agents.near_counts[:, 0, kind]):
            found.append(lists[agent, 0, :4, :count].astype(np.float64))
            whose.append(np.full(count, agent))
    rows, owners = np.concatenate(found, axis=1), np.concatenate(whose)
    inside = (np.abs(rows[:2] - CHUNK_M / 2) < 5.0 + CHUNK_M / 2).all(axis=0)
    return simulation, rows[:, inside], owners[inside]


WINDOW_M = 2 * 5.0 + CHUNK_M


def assert_even(column: Floats, low: float, high: float) -> None:
    """Kolmogorov and Smirnov: 1.95/√n is passed by chance once in a thousand."""
    steps = (np.arange(len(column)) + 0.5) / len(column)
    off = np.abs(np.sort((column - low) / (high - low)) - steps).max()
    assert off < 1.95 / math.sqrt(len(column))


@pytest.mark.parametrize("density", [0.02, 0.4, 3.0])
def test_counts_are_poisson(density: float) -> None:
    _, rows, whose = around(Scatter(density, (SPECKS,)))
    counts, mean = np.bincount(whose, minlength=4096), density * WINDOW_M**2
    assert counts.mean() == pytest.approx(mean, abs=4 * math.sqrt(mean / 4096))
    assert counts.var() == pytest.approx(mean, rel=4 * math.sqrt((2 + 1 / mean) / 4096))
    assert len(rows.T) == counts.sum()


def test_places_and_sizes_are_uniform_and_independent() -> None:
    _, (x, y, half_length, half_width), _ = around(Scatter(0.4, (SPECKS,)))
    columns = [x % CHUNK_M, y % 2.5, half_length, half_width]
    for column, (low, high) in zip(
        columns, [(0, 2.5), (0, 2.5), (0.015, 0.025), (0.005, 0.01)], strict=True
    ):
        assert_even(column, low, high)
    correlation = np.corrcoef(columns) - np.eye(4)
    assert np.abs(correlation).max() < 4 / math.sqrt(len(x))


def test_neighbouring_chunks_and_seeds_are_independent() -> None:
    _, (x, y, _, _), whose = around(Scatter(0.4, (SPECKS,)))
    chunks = ((x // CHUNK_M).astype(int) + 2) * 5 + (y // CHUNK_M).astype(int) + 2
    counts = np.zeros((4096, 25))
    np.add.at(counts, (whose, chunks), 1)
    correlation = np.corrcoef(counts.T) - np.eye(25)
    assert np.abs(correlation).max() < 5 / 64
    assert np.abs(np.corrcoef(counts) - np.eye(4096)).mean() < 0.25


def test_a_mixture_has_its_shares() -> None:
    small = Discs((0.01, 0.02), share=1.0), Rectangles((0.01, 0.02), (0.03, 0.05), share=3.0)
    simulation, _, _ = around(Scatter(0.4, small))
    counts = simulation.params.agents.near_counts[:, 0].sum(axis=0)
    share = counts[DISCS] / counts.sum()
    assert share == pytest.approx(0.25, abs=4 * math.sqrt(0.1875 / counts.sum()))


@pytest.mark.parametrize("gap_m", [0.3, 1.0, 1.25])
def test_thinning_keeps_matern_s_density_and_his_distance(gap_m: float) -> None:
    layer = Scatter(0.6, (SPECKS,), gap_m=gap_m)
    _, (x, y, _, _), whose = around(layer)
    expected = 4096 * WINDOW_M**2 * layer.mean_density_per_m2
    # Thinned points repel each other: their number varies less than Poisson's.
    assert len(x) == pytest.approx(expected, abs=4 * math.sqrt(expected))
    closest_m = math.inf
    for agent in range(300):
        places = np.stack([x[whose == agent], y[whose == agent]], axis=1)
        apart_m = np.linalg.norm(places[:, np.newaxis] - places, axis=2)
        closest_m = min(
            closest_m, float(apart_m[~np.eye(len(places), dtype=bool)].min(initial=9.0))
        )
    assert gap_m < closest_m < gap_m + 0.1


def test_sections_have_each_its_density_and_begin_again() -> None:
    factors = (1.0, 2.0, 0.0, 0.5)
    _, (x, *_), _ = around(Scatter(0.4, (SPECKS,), sections=factors, section_m=2.5))
    counts = np.bincount((x // CHUNK_M).astype(int) + 2, minlength=5)
    area_m2 = 4096 * CHUNK_M * WINDOW_M
    for chunk, count in zip(range(-2, 3), counts, strict=True):
        expected = 0.4 * factors[chunk % 4] * area_m2
        assert count == pytest.approx(expected, abs=4 * math.sqrt(expected))


def test_the_densest_section_that_can_be_is_as_dense_as_it_says() -> None:
    grain = Rectangles((0.001, 0.002), (0.001, 0.002))
    layer = Scatter(16.0, (grain,), sections=(10.0, 0.0), section_m=2.5)
    world = World("dense", layers=(layer,))
    counts = [len(outlines_of_chunk(world, seed, 0, 0)) for seed in range(12)]
    assert np.mean(counts) == pytest.approx(1000.0, abs=4 * math.sqrt(1000.0 / 12))
    tables = world_tables([world], PolicyContract())
    assert (np.diff(tables.counts, axis=-1) >= 0.0).all()


@pytest.mark.parametrize("shape", [Polygons((0.2, 0.9), (4, 9), (0.1, 0.6)), Curves()])
def test_polygons_and_curves_have_the_widths_and_areas_that_are_reckoned_with(shape: Shape) -> None:
    world = World("shapes", layers=(Scatter(0.8, (shape,)),))
    outlines = [o for i in range(40) for j in range(8) for o in outlines_of_chunk(world, 3, i, j)]
    widths_m = np.array([np.ptp(o.corners_m[:, 1]) for o in outlines])
    areas_m2 = np.array([area_m2(o.corners_m - o.corners_m.mean(axis=0)) for o in outlines])
    for found, expected in ((widths_m, shape.mean_width_m), (areas_m2, shape.mean_area_m2)):
        error = float(found.std()) / math.sqrt(len(found))
        assert expected == pytest.approx(found.mean(), abs=4 * error + 0.01 * expected)
    assert (areas_m2 > 0.0).all()  # counter-clockwise


def test_a_turned_rectangle_is_a_rectangle_of_its_sides() -> None:
    shape = Rectangles(width_m=(0.4, 0.4), length_m=(1.0, 1.0), turned_rad=(0.3, 0.6))
    world = World("turned", layers=(Scatter(0.4, (shape,)),))
    for outline in outlines_of_chunk(world, 1, 0, 0) + outlines_of_chunk(world, 1, 1, 0):
        edges = np.roll(outline.corners_m, -1, axis=0) - outline.corners_m
        np.testing.assert_allclose(np.hypot(*edges.T), [1.0, 0.4, 1.0, 0.4], atol=1e-9)
        turned = math.atan2(*-edges[0, ::-1])
        assert 0.3 <= turned <= 0.6


def lateral_cover(world: World, chunks: int) -> Floats:
    """Obstacle length per length of the way in 12 lanes, by their middle lines."""
    lanes_m = (np.arange(12) + 0.5) / 12 * world.width_m
    across = range(round(world.width_m / CHUNK_M))
    found = [o for i in range(chunks) for j in across for o in outlines_of_chunk(world, 7, i, j)]
    spans = np.array([(o.y_m, *np.ptp(o.corners_m, axis=0)) for o in found])
    off_m = np.abs(spans[:, :1] - lanes_m)
    if world.edges is Edges.PERIODIC:
        off_m = np.minimum(off_m, world.width_m - off_m)
    cover: Floats = ((off_m < spans[:, 2:] / 2) * spans[:, 1:2]).sum(axis=0) / (chunks * CHUNK_M)
    return cover


def test_a_periodic_world_is_covered_evenly_across() -> None:
    cover = lateral_cover(PLAIN, 500)
    assert cover.mean() == pytest.approx(0.27, rel=0.06)
    assert np.abs(cover / cover.mean() - 1.0).max() < 0.18


def test_an_open_world_is_thin_at_its_edges_and_its_obstacles_lie_between_them() -> None:
    world = World("open", width_m=12.0, edges=Edges.OPEN)
    cover = lateral_cover(world, 500)
    assert cover[[0, -1]].max() < 0.75 * cover[4:8].mean()
    corners = [
        o.corners_m for i in range(300) for j in range(5) for o in outlines_of_chunk(world, 7, i, j)
    ]
    y_m = np.concatenate(corners)[:, 1]
    assert -1e-12 <= y_m.min() < 0.01
    assert 11.99 < y_m.max() <= 12.0 + 1e-12


@pytest.mark.parametrize("width_m", [1.6, 2.5, 3.2])
def test_an_open_world_may_be_little_wider_than_its_obstacles(width_m: float) -> None:
    layer = Scatter(0.4, (Rectangles(width_m=(0.3, 1.5), length_m=(0.3, 1.5)),))
    world = World("lane", width_m=width_m, edges=Edges.OPEN, layers=(layer,))
    simulation = Simulation(world, PolicyContract(), np.arange(64, dtype=np.uint64))
    assert simulation.params.agents.near_counts.max() > 3
