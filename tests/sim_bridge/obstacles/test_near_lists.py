import dataclasses
import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_sim_bridge.arrays.layout import BOXES, DISCS, SIDES, TURNED, Floats32
from reflexarc_sim_bridge.simulation.scene import Outline
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layers import (
    Automaton,
    Corridor,
    Drift,
    Gates,
    Layer,
    Motion,
    Scatter,
    Swing,
)
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import Edges, World
from support.drawn_worlds import SIDEWAYS, TURNING, worlds
from support.slow_geometry import clearances_m
from support.slow_world import outlines_around

ROUND_EYE = PolicyContract(
    retina=RetinaSpec(rays=8, fov_rad=math.tau, range_m=3.0), actions=TURNING
)


def drive(simulation: Simulation, steps: int, seed: int) -> None:
    generator = np.random.default_rng(seed)
    for _ in range(steps):
        simulation.step(generator.integers(0, 3, len(simulation)))


def forget(simulation: Simulation) -> None:
    """Make every agent gather anew what is near it, at its next step."""
    simulation.params.agents.layer_cells[:] = 1 << 40


def near_lists(simulation: Simulation) -> list[Floats32]:
    """In the order of their counts: (agents, layers, rows, columns) each."""
    agents, order = simulation.params.agents, {BOXES: 0, TURNED: 1, DISCS: 2, SIDES: 3}
    assert list(order) == sorted(order), "the order of the counts"
    return [agents.boxes, agents.turned, agents.discs, agents.sides]


def lists(simulation: Simulation) -> list[bytes]:
    """The columns in use of every list, and the cells that they are of."""
    agents, found = simulation.params.agents, [simulation.params.agents.layer_cells.tobytes()]
    for agent, layer in np.ndindex(agents.near_counts.shape[:2]):
        counts = agents.near_counts[agent, layer]
        for kind, near in enumerate(near_lists(simulation)):
            found.append(near[agent, layer, :, : counts[kind]].tobytes())
    return found


@given(worlds, st.integers(0, 2**64 - 1))
@example(World("plain"), 5)
@example(World("lane", width_m=6.0, edges=Edges.OPEN), 5)
@settings(max_examples=30, deadline=None)
def test_what_is_near_does_not_depend_on_the_way_there(world: World, seed: int) -> None:
    """Whoever has driven here has the same lists as who gathers them here for the first time."""
    came = Simulation(world, ROUND_EYE, np.array([seed, seed + 1 & 2**64 - 1], np.uint64))
    drive(came, 40, seed)
    fell = Simulation(world, ROUND_EYE, came.params.agents.state["seed"].copy())
    fell.restore(came.state())
    forget(fell)
    still = np.array([1, 2])
    for simulation in (came, fell):
        simulation.params.agents.state["is_inside"] = 1  # it meets nothing on the last step
        simulation.step(still)
        simulation.params.agents.state["is_inside"] = 0
    assert lists(came) == lists(fell)
    assert came.sense().tobytes() == fell.sense().tobytes()


@given(worlds, st.integers(0, 2**64 - 1))
@example(World("plain"), 5)
@example(World("lane", width_m=6.0, edges=Edges.OPEN), 5)
@settings(max_examples=20, deadline=None)
def test_everything_in_reach_is_listed_where_it_is(world: World, seed: int) -> None:
    simulation = Simulation(world, ROUND_EYE, np.array([seed], np.uint64))
    drive(simulation, 25, seed)
    assert_listed(simulation, 3.0)


def assert_listed(simulation: Simulation, within_m: float) -> int:
    """All that is so near to the first agent is in its lists; returns how many that is."""
    place_m, found = np.array([[simulation.x_m[0], simulation.y_m[0]]]), 0
    near = simulation.outlines_near(0)
    places_m = np.array([(o.x_m, o.y_m) for o in near]).reshape(-1, 2)
    for outline in outlines_around(simulation, 0, within_m):
        if clearances_m([outline], place_m)[0, 0] < within_m - 1e-3:
            off_m = np.abs(places_m - (outline.x_m, outline.y_m)).sum(axis=1)
            assert any(is_same(outline, near[k]) for k in np.flatnonzero(off_m < 1e-4))
            found += 1
    return found


def is_same(outline: Outline, listed: Outline) -> bool:
    """To some micrometres: what is near is kept in float32."""
    turns = (listed.corners_m, np.roll(listed.corners_m, -1, axis=0))  # begun with any corner
    return bool(
        (outline.layer, bool(outline.is_box), outline.colour)
        == (listed.layer, bool(listed.is_box), listed.colour)
        and abs(outline.radius_m - listed.radius_m) < 1e-6
        and outline.corners_m.shape == listed.corners_m.shape
        and any(np.abs(outline.corners_m - turn).max(initial=0.0) < 1e-5 for turn in turns)
    )


@pytest.mark.parametrize("motion", [None, Drift(-3.0, 0.7)])
@pytest.mark.parametrize("edges", [Edges.PERIODIC, Edges.UNBOUNDED])
@pytest.mark.parametrize("width_m", [1.3, 10.2, 12.1, 20.0])
def test_fields_of_white_boxes_hold_the_same_as_those_of_grey_ones(
    width_m: float, edges: Edges, motion: Motion | None
) -> None:
    """White upright boxes are gathered in a way of their own, which must list the same."""
    found = []
    for colour in ((1.0, 1.0), (0.1, 0.9)):
        layer = Scatter(0.3, colour=(colour,), motion=motion)
        world = World("boxes", width_m=width_m, edges=edges, layers=(layer,))
        simulation = Simulation(world, ROUND_EYE, test_seeds(60))
        drive(simulation, 20, 3)
        agents = simulation.params.agents
        for agent, count in enumerate(agents.near_counts[:, 0, BOXES]):
            columns = agents.boxes[agent, 0, :4, :count]
            found.append(columns[:, np.lexsort(columns)])
    for white, grey in zip(found[:60], found[60:], strict=True):
        np.testing.assert_allclose(white, grey, rtol=0.0, atol=1e-6)  # some float32 more or less
    assert len({columns.tobytes() for columns in found[:60]}) > 50


CROWDED: dict[str, tuple[Layer, Edges, float]] = {
    "rectangles": (Scatter(1.2), Edges.PERIODIC, 20.0),
    "discs": (Scatter(1.5, (Discs(),)), Edges.PERIODIC, 20.0),
    "mixed": (Scatter(1.0, (Discs(), Polygons(corners=(3, 32)), Curves())), Edges.PERIODIC, 20.0),
    "sections": (Scatter(0.2, sections=(6.0, 0.1), section_m=2.5), Edges.PERIODIC, 20.0),
    "large": (Scatter(0.01, (Rectangles((8.0, 10.0), (8.0, 10.0)),)), Edges.PERIODIC, 20.0),
    "open": (Scatter(1.0), Edges.OPEN, 12.0),
    "lane": (Scatter(1.5, (Rectangles((0.3, 1.5), (0.3, 1.5)),)), Edges.OPEN, 1.6),
    "gates": (Gates(spacing_m=2.5, pitch_m=2.5, opening_m=(0.5, 1.0)), Edges.PERIODIC, 20.0),
    "automaton": (Automaton(16, 0.5, 0), Edges.PERIODIC, 20.0),
    "cells": (Automaton(16, 0.6, 4), Edges.UNBOUNDED, 20.0),
    "corridor": (Corridor(4.0, 10.0, 20.0), Edges.UNBOUNDED, 20.0),
    "drifting": (Scatter(1.0, motion=Drift(-20.0, 3.0)), Edges.PERIODIC, 20.0),
    "swinging": (Scatter(1.0, (Curves(),), motion=Swing(0.0, 3.0, 1.0)), Edges.UNBOUNDED, 20.0),
}


@pytest.mark.parametrize("name", CROWDED)
@pytest.mark.parametrize("range_m", [0.4, 5.0])
def test_no_list_is_ever_full(name: str, range_m: float) -> None:
    layer, edges, width_m = CROWDED[name]
    world = World(name, width_m=width_m, layers=(layer,), edges=edges)
    contract = PolicyContract(retina=RetinaSpec(rays=8, range_m=range_m), actions=TURNING)
    simulation = Simulation(world, contract, test_seeds(100))
    agents, most = simulation.params.agents, np.zeros(4, np.int64)
    for part in range(3):
        drive(simulation, 5, part)
        most = np.maximum(most, agents.near_counts.max(axis=(0, 1)))
    capacities = [near.shape[3] for near in near_lists(simulation)]
    # A column is spare. Walls and cells need what they can need at most; others never do.
    spare = 0 if not isinstance(layer, Scatter) else (most > 0)
    assert (most + spare <= np.array(capacities) - 1).all()
    assert most.sum() > 3


def test_an_eye_that_looks_ahead_alone_keeps_less_behind() -> None:
    ahead, round_about = (
        Simulation(World("plain"), dataclasses.replace(ROUND_EYE, actions=actions), test_seeds(200))
        for actions in (SIDEWAYS, TURNING)
    )
    half = PolicyContract(retina=RetinaSpec(rays=8, range_m=3.0), actions=SIDEWAYS)
    less = Simulation(World("plain"), half, test_seeds(200))
    counts = [s.params.agents.near_counts.sum() for s in (less, ahead, round_about)]
    assert counts[0] < 0.8 * counts[1]
    assert 0.95 * counts[2] < counts[1] <= counts[2]


def test_a_narrow_period_shows_its_obstacles_again() -> None:
    world = World("narrow", width_m=4.0)
    simulation = Simulation(world, PolicyContract(), test_seeds(3))
    near = simulation.outlines_near(0)
    again = sorted(o.y_m for o in near if abs(o.x_m - near[0].x_m) < 1e-6)
    assert len(again) >= 3
    np.testing.assert_allclose(np.diff(again), 4.0, atol=1e-5)


@pytest.mark.parametrize("name", ["mixed", "gates", "automaton", "drifting"])
def test_a_million_kilometres_away_a_world_is_as_exact(name: str) -> None:
    """The generator's own places there, against what an agent keeps near in float32."""
    layer, edges, width_m = CROWDED[name]
    world = World(name, width_m=width_m, layers=(layer,), edges=edges)
    simulation = Simulation(world, ROUND_EYE, test_seeds(1))
    for cells in (400_000_000, -400_000_000):
        state = simulation.params.agents.state
        state["cell_x"], state["is_inside"] = cells, 1
        simulation.step(np.zeros(1, np.int64))
        state["is_inside"] = 0
        # A billion metres are good to 0.2 µm in float64, as a few metres are in float32.
        assert assert_listed(simulation, 2.9) > 0
