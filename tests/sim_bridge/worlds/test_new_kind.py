"""A new kind of layer takes its two modules and its name in `Layer`, and nothing else."""

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import pytest

from reflexarc_runtime.config import annotations
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.arrays.layout import layer_dtype
from reflexarc_sim_bridge.simulation.scene import outlines_of_chunk
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds import layers
from reflexarc_sim_bridge.worlds.files import parse_world
from reflexarc_sim_bridge.worlds.layers import CHUNK_M, Gates, layer_kinds
from reflexarc_sim_bridge.worlds.world import World
from support.fence.worlds.kinds.fence import Fence

SPACING_M, PITCH_M, RADIUS_M, BODY_M, WIDTH_M = 7.5, 2.0, 0.4, 0.2, 20.0
FENCED = f"""
name = "fenced"
width_m = {WIDTH_M}
[chassis]
radius_m = {BODY_M}
[[layers]]
kind = "fence"
spacing_m = {SPACING_M}
pitch_m = {PITCH_M}
radius_m = {RADIUS_M}
"""
AHEAD = PolicyContract(
    retina=RetinaSpec(rays=16, range_m=5.0),
    actions=(Action("ahead", 1.0, 0.0), Action("stand", 0.0, 0.0)),
)
AGENTS, SECONDS = 24, 30.0


@pytest.fixture(autouse=True)
def _with_fences(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """As if `layers.py` had named it: `Layer` is the one table, which `World` reads on import."""
    extended = layers.Layer | Fence
    monkeypatch.setattr(layers, "Layer", extended)
    monkeypatch.setitem(World.__annotations__, "layers", tuple[extended, ...])
    annotations.fields_of.cache_clear()
    yield
    annotations.fields_of.cache_clear()


def world() -> World:
    return parse_world(FENCED).drawn(0)


def first_met_m(x_m: float, y_m: float, until_m: float) -> float:
    """Where along x a body that drives straight ahead meets a post, by trying all of them."""
    met = math.inf
    for row in range(100):
        post_x_m = row * SPACING_M + CHUNK_M / 2
        for post in range(-10, 20):
            beside_m = post * PITCH_M - y_m
            if abs(beside_m) <= RADIUS_M + BODY_M:
                touch_m = post_x_m - math.sqrt((RADIUS_M + BODY_M) ** 2 - beside_m**2)
                if x_m < touch_m <= until_m:
                    met = min(met, touch_m)
    return met


def test_its_place_in_the_table_is_its_number() -> None:
    assert layer_kinds().index(Fence) == 4
    assert type(world().layers[0]) is Fence


def test_a_file_that_gets_it_wrong_is_told_so() -> None:
    with pytest.raises(WorldError, match=r"line 9: .*pitch_m: expected 0.1 to 10000, got 0.0"):
        parse_world(FENCED.replace(f"pitch_m = {PITCH_M}", "pitch_m = 0.0"))
    with pytest.raises(WorldError, match=r"expected one of scatter, .*, fence, got"):
        parse_world(FENCED.replace('"fence"', '"hedge"'))


def test_its_scene_is_drawn() -> None:
    posts = [o for j in range(8) for i in range(7) for o in outlines_of_chunk(world(), 3, i, j)]
    places = sorted((post.x_m, post.y_m) for post in posts)
    rows = [row * SPACING_M + CHUNK_M / 2 for row in range(3)]
    expected = [(x_m, post * PITCH_M) for x_m in rows for post in range(10)]
    np.testing.assert_allclose(places, expected)
    assert {post.radius_m for post in posts} == {RADIUS_M}


def test_agents_meet_it_where_the_oracle_says() -> None:
    simulation = Simulation(world(), AHEAD, np.arange(AGENTS, dtype=np.uint64))
    standing, contacts = np.zeros(AGENTS, np.int64), 0
    for _ in range(round(SECONDS / simulation.dt_s)):
        x_m, y_m = simulation.x_m, simulation.y_m
        met = simulation.step(standing)
        for agent in range(AGENTS):
            expected_m = first_met_m(x_m[agent], y_m[agent], x_m[agent] + simulation.dt_s)
            assert met[agent] == (expected_m < math.inf)
            if met[agent]:
                assert simulation.x_m[agent] == pytest.approx(expected_m, abs=1e-5)
        contacts += int(met.sum())
    assert contacts > AGENTS


def test_agents_see_it_where_it_is_and_it_is_near_them() -> None:
    simulation = Simulation(world(), AHEAD, np.arange(AGENTS, dtype=np.uint64))
    assert simulation.sense().max() > 0
    for outline in simulation.outlines_near(0):
        assert outline.radius_m == pytest.approx(RADIUS_M)
        assert (outline.x_m - CHUNK_M / 2) % SPACING_M == pytest.approx(0.0, abs=1e-5)


def test_columns_of_one_name_have_one_meaning() -> None:
    class Pitch(NamedTuple):
        pitch_m: int

    class Reach(NamedTuple):
        reach_m: float

    for columns in (Pitch, Reach):
        kind = type("Odd", (), {"COLUMNS": columns})
        with pytest.raises(TypeError, match=r"Odd.COLUMNS: .*expected a name that is not taken"):
            layer_dtype([Gates, kind])
    assert "pitch_m" in (layer_dtype([Gates]).names or ())
