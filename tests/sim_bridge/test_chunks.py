import dataclasses
import hashlib
import itertools

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.chunks import obstacles_of_chunk
from reflexarc_sim_bridge.params import CHUNK_M
from reflexarc_sim_bridge.world_files import world_named
from reflexarc_sim_bridge.worlds import World

REFERENCE = world_named("reference-1")


def digest(obstacles: npt.NDArray[np.void]) -> str:
    return hashlib.sha256(obstacles.tobytes()).hexdigest()


def many(world: World, chunks: int) -> npt.NDArray[np.void]:
    return np.concatenate([obstacles_of_chunk(world, 7, i) for i in range(chunks)])


def test_chunks_asked_for_in_any_order_are_the_same() -> None:
    forwards = {i: digest(obstacles_of_chunk(REFERENCE, 3, i)) for i in range(-20, 20)}
    backwards = {i: digest(obstacles_of_chunk(REFERENCE, 3, i)) for i in reversed(range(-20, 20))}
    assert forwards == backwards
    assert len(set(forwards.values())) == 40


def test_the_reference_world_never_changes() -> None:
    # A change here is a new GENERATOR_VERSION and a new reference field.
    chunks = (obstacles_of_chunk(REFERENCE, seed, i) for seed in (0, 2**64 - 1) for i in (-1, 0, 9))
    found = hashlib.sha256(b"".join(c.tobytes() for c in chunks)).hexdigest()
    assert found == "061dd49370267dc2902e5bb269264a092ab982d03f5e945eab17bfed05847940"


def test_seed_chunk_and_stream_each_make_another_world() -> None:
    other = dataclasses.replace(REFERENCE, stream=1)
    keys = itertools.product((REFERENCE, other), (0, 1, 2**63), (-1, 0, 1))
    assert len({digest(obstacles_of_chunk(*key)) for key in keys}) == 18


def test_an_obstacle_belongs_to_the_chunk_of_its_centre() -> None:
    for i in (-3, 0, 1_000_000):
        x_m = obstacles_of_chunk(REFERENCE, 1, i)["x_m"]
        assert ((x_m >= i * CHUNK_M) & (x_m <= (i + 1) * CHUNK_M)).all()


def test_counts_are_poisson() -> None:
    counts = np.array([len(obstacles_of_chunk(REFERENCE, 5, i)) for i in range(4000)])
    mean = REFERENCE.density_per_m2 * REFERENCE.width_m * CHUNK_M
    assert counts.mean() == pytest.approx(mean, abs=4 * np.sqrt(mean / 4000))
    assert counts.var() == pytest.approx(mean, rel=4 * np.sqrt(2 / 4000))


def test_places_and_sizes_are_uniform_and_independent() -> None:
    found = many(REFERENCE, 1000)
    columns = [
        found["x_m"] % CHUNK_M / CHUNK_M,
        found["y_m"] / 20.0,
        (2 * found["half_width_m"] - 0.3) / 1.2,
        (2 * found["half_length_m"] - 0.3) / 0.9,
    ]
    for column in columns:
        # Kolmogorov and Smirnov: 1.95/√n is passed by chance once in a thousand.
        steps = np.arange(1, len(column) + 1) / len(column)
        assert np.abs(np.sort(column) - steps).max() < 1.95 / np.sqrt(len(column))
    correlation = np.corrcoef(columns) - np.eye(4)
    assert np.abs(correlation).max() < 4 / np.sqrt(len(found))


def test_a_mixture_has_its_shares_and_discs_are_round() -> None:
    found = many(world_named("mixed"), 500)
    assert found["round"].mean() == pytest.approx(0.5, abs=4 * 0.5 / np.sqrt(len(found)))
    discs = found[found["round"]]
    np.testing.assert_array_equal(discs["half_length_m"], discs["half_width_m"])
    assert discs["half_width_m"].min() >= 0.15
    assert discs["half_width_m"].max() <= 0.75


def lateral_cover(world: World, chunks: int) -> npt.NDArray[np.float64]:
    """Obstacle length per length of corridor in 12 lanes, by their middle lines."""
    lanes_m = (np.arange(12) + 0.5) / 12 * world.width_m
    found = many(world, chunks)
    off_m = np.abs(found["y_m"][:, np.newaxis] - lanes_m)
    if world.name != "legacy":
        off_m = np.minimum(off_m, world.width_m - off_m)
    covered = off_m < found["half_width_m"][:, np.newaxis]
    cover: npt.NDArray[np.float64] = (covered * 2 * found["half_length_m"][:, np.newaxis]).sum(0)
    return cover / (chunks * CHUNK_M)


def test_a_periodic_world_is_covered_evenly_across() -> None:
    cover = lateral_cover(REFERENCE, 6000)
    assert cover.mean() == pytest.approx(0.27, rel=0.02)
    assert np.abs(cover / cover.mean() - 1.0).max() < 0.05


def test_the_legacy_world_is_thin_at_its_edges() -> None:
    cover = lateral_cover(world_named("legacy"), 2000)
    assert cover[[0, -1]].max() < 0.75 * cover[4:8].mean()
    assert np.abs(cover[3:9] / cover[3:9].mean() - 1.0).max() < 0.08


def test_legacy_obstacles_lie_whole_inside_the_corridor() -> None:
    found = many(world_named("legacy"), 200)
    assert (found["y_m"] - found["half_width_m"]).min() >= -1e-12
    assert (found["y_m"] + found["half_width_m"]).max() <= 12.0 + 1e-12
