import math

import numpy as np
import pytest

from reflexarc_sim_bridge.simulation.scene import Outline, outlines_of_chunk
from reflexarc_sim_bridge.worlds.layers import CHUNK_M, Gates
from reflexarc_sim_bridge.worlds.world import Edges, World
from support.slow_world import side_m


def wall_at(world: World, seed: int, i: int, chunks: range) -> list[Outline]:
    return [o for j in chunks for o in outlines_of_chunk(world, seed, i, j)]


def openings_m(pieces: list[Outline], low_m: float, high_m: float) -> list[tuple[float, float]]:
    """Where a wall is open between two lateral places: (from, to)."""
    spans = sorted((float(o.corners_m[:, 1].min()), float(o.corners_m[:, 1].max())) for o in pieces)
    found, reached_m = [], low_m
    for begins_m, ends_m in spans:
        if begins_m > reached_m + 1e-9:
            found.append((reached_m, begins_m))
        reached_m = max(reached_m, ends_m)
    return [*found, (reached_m, high_m)] if reached_m < high_m - 1e-9 else found


def begins_of_pitches_m(openings: list[tuple[float, float]], pitch_m: float) -> tuple[float, float]:
    """Between which places the first pitch can begin, if each holds one opening, in their order."""
    latest = min(begins_m - k * pitch_m for k, (begins_m, _) in enumerate(openings))
    earliest = max(ends_m - (k + 1) * pitch_m for k, (_, ends_m) in enumerate(openings))
    return earliest, latest


@pytest.mark.parametrize(
    ("width_m", "pitch_m", "pitches"),
    [(20.0, 10.0, 2), (20.0, 2.5, 8), (7.6, 3.0, 3), (20.0, 7.0, 3), (6.0, 50.0, 1)],
)
def test_every_pitch_of_a_wall_has_one_opening_of_a_drawn_width(
    width_m: float, pitch_m: float, pitches: int
) -> None:
    gates = Gates(spacing_m=5.0, pitch_m=pitch_m, opening_m=(0.5, 1.5))
    world, widths_m = World("gates", width_m=width_m, layers=(gates,)), []
    chunks = round(width_m / side_m(world))
    for i in range(-20, 20, 2):
        periods = openings_m(
            wall_at(world, 5, i, range(-chunks, 2 * chunks)), -width_m, 2 * width_m
        )
        openings = [opening for opening in periods if 0.0 <= opening[0] < width_m]
        assert len(openings) == pitches
        earliest_m, latest_m = begins_of_pitches_m(openings, width_m / pitches)
        assert earliest_m <= latest_m + 1e-9
        widths_m += [ends_m - begins_m for begins_m, ends_m in openings]
        corners = np.concatenate([o.corners_m for o in wall_at(world, 5, i, range(chunks))])
        middle_m = i * CHUNK_M + CHUNK_M / 2
        np.testing.assert_allclose(np.abs(corners[:, 0] - middle_m), 0.15, atol=1e-9)
    assert 0.5 <= min(widths_m) < 0.7
    assert 1.3 < max(widths_m) <= 1.5
    assert not wall_at(world, 5, 1, range(chunks))


def test_a_wall_is_periodic_across_and_cut_at_the_borders_of_chunks() -> None:
    world = World("gates", width_m=7.5, layers=(Gates(spacing_m=2.5, pitch_m=7.5),))
    for i in range(6):
        twice = openings_m(wall_at(world, 2, i, range(-3, 6)), -7.5, 15.0)
        assert len(twice) == 3
        np.testing.assert_allclose(np.diff([a for a, _ in twice]), 7.5)
        for j in range(-3, 6):
            for piece in outlines_of_chunk(world, 2, i, j):
                assert piece.corners_m[:, 1].min() >= 2.5 * j - 1e-9
                assert piece.corners_m[:, 1].max() <= 2.5 * (j + 1) + 1e-9


def test_without_sides_every_pitch_has_an_opening_of_its_own() -> None:
    gates = Gates(spacing_m=2.5, pitch_m=7.0, opening_m=(1.0, 2.0))
    world = World("gates", edges=Edges.UNBOUNDED, layers=(gates,))
    wall = openings_m(wall_at(world, 2, 3, range(-28, 28)), -70.0, 70.0)
    openings = wall[1:-1]  # the borders of what is looked at may cut the others
    assert 17 <= len(openings) <= 20
    earliest_m, latest_m = begins_of_pitches_m(openings, 7.0)
    assert earliest_m <= latest_m + 1e-9
    starts = [begins_m - 7.0 * k for k, (begins_m, _) in enumerate(openings)]
    assert np.std(starts) > 0.8


def test_openings_are_anywhere_across() -> None:
    gates = Gates(spacing_m=2.5, pitch_m=5.0, opening_m=(1.0, 1.0))
    world, begins = World("gates", width_m=5.0, layers=(gates,)), []
    for i in range(800):
        openings = openings_m(wall_at(world, 1, i, range(-2, 4)), -5.0, 10.0)
        begins += [begins_m for begins_m, _ in openings if 0.0 <= begins_m < 5.0]
    steps = (np.arange(800) + 0.5) / 800
    assert np.abs(np.sort(begins) / 5.0 - steps).max() < 1.95 / math.sqrt(800)
