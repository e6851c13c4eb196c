"""The parts of the world's step: compiled where a world needs them, called with what they take."""

import math
import pickle
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.simulation import step_compilation
from reflexarc_sim_bridge.simulation.simulation import Simulation, motions_of
from reflexarc_sim_bridge.simulation.step_compilation import CompiledStep, step_for
from reflexarc_sim_bridge.worlds.files import parse_world
from reflexarc_sim_bridge.worlds.layers import (
    Automaton,
    Corridor,
    Drift,
    Gates,
    Layer,
    Scatter,
    layer_kinds,
)
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.shapes import Discs, Rectangles
from reflexarc_sim_bridge.worlds.world import Edges, World, WorldSource


def step_of(source: WorldSource) -> CompiledStep:
    contract = reference_contract()
    simulation = Simulation(source, contract, np.arange(4, dtype=np.uint64))
    return step_for(source, simulation.params, motions_of(contract))


def gathered(source: WorldSource) -> set[str]:
    """Kinds of layers that are gathered; on a belt with that word behind it."""
    names = [kind.__name__.lower() for kind in layer_kinds()]
    addresses = step_of(source).parts.gatherers.addresses
    return {f"{names[kind]}{' belt' * belt}" for kind, belt in np.argwhere(addresses != 0)}


THINNED = Scatter(gap_m=0.5)
GATES, DISCS = Gates(), Scatter(density_per_m2=0.1, shapes=(Discs(),))


@pytest.mark.parametrize(
    ("layers", "needed"),
    [
        ((), {"scatter"}),  # a row of zeros is an empty scatter, which is never gathered
        ((Scatter(),), {"scatter belt"}),
        ((Scatter(shapes=(Rectangles(turned_rad=(0.0, 1.0)),)),), {"scatter belt"}),
        ((THINNED,), {"scatter"}),
        ((DISCS, Scatter(motion=Drift(-1.0, 0.0))), {"scatter", "scatter belt"}),
        ((GATES,), {"gates"}),
        ((GATES, Scatter(density_per_m2=0.05)), {"gates", "scatter belt"}),
        ((Automaton(), THINNED), {"automaton", "scatter"}),
    ],
)
def test_a_world_has_the_parts_that_its_layers_need(
    layers: tuple[Layer, ...], needed: set[str]
) -> None:
    assert gathered(World("some", layers=layers)) == needed


def test_where_there_is_no_period_there_is_no_belt() -> None:
    assert gathered(World("lane", width_m=6.0, edges=Edges.OPEN)) == {"scatter"}
    layers = Corridor(), Scatter(density_per_m2=0.05)
    assert gathered(World("canyon", edges=Edges.UNBOUNDED, layers=layers)) == {
        "corridor",
        "scatter",
    }


NARROW_OR_WIDE = """
name = "narrow or wide"
width_m = { from = 6.0, to = 30.0 }
[[layers]]
kind = "scatter"
density_per_m2 = 0.3
"""


def test_around_a_very_wide_world_there_is_no_belt() -> None:
    worlds = [World("wide", width_m=width_m, layers=(Scatter(),)) for width_m in (500.0, 501.0)]
    assert [gathered(world) for world in worlds] == [{"scatter belt"}, {"scatter"}]


def test_in_a_family_one_world_may_have_a_belt_and_the_next_none() -> None:
    family, seeds = parse_world(NARROW_OR_WIDE), np.arange(12, dtype=np.uint64)
    together = Simulation(family, reference_contract(), seeds)
    belts = together.params.world.layers["has_belt"][:, 0]
    assert set(belts.tolist()) == {0, 1}
    assert gathered(family) == {"scatter", "scatter belt"}
    alone = [
        Simulation(family.drawn(int(s)), reference_contract(), seeds[s : s + 1]) for s in seeds
    ]
    for _ in range(30):
        met = together.step_and_sense(np.ones(12, np.int64))
        apart = [one.step_and_sense(np.ones(1, np.int64))[0] for one in alone]
        assert met.tolist() == apart
    assert together.stacks.tobytes() == b"".join(one.stacks.tobytes() for one in alone)


def test_an_agent_goes_on_where_its_next_world_has_no_belt() -> None:
    family = parse_world(NARROW_OR_WIDE)
    simulation = Simulation(family, reference_contract(), np.zeros(1, np.uint64))
    for seed in range(1, 12):
        simulation.place(np.zeros(1, np.int64), np.array([seed], np.uint64))
        scratch = simulation.held_step()[1].value.work.draws.keys
        assert len(scratch) >= simulation.params.world.planes["across"].max()
        fresh = Simulation(family, reference_contract(), np.array([seed], np.uint64))
        assert simulation.sense().tobytes() == fresh.sense().tobytes()


LONG_OR_SHORT = """
name = "long or short"
width_m = 18.0
[[layers]]
kind = "scatter"
density_per_m2 = 0.2
[[layers.shapes]]
kind = "rectangles"
length_m = [0.2, { from = 0.3, to = 9.0 }]
"""


def test_where_the_fullest_world_has_no_room_for_a_belt_no_world_has_one() -> None:
    """Its boxes reach too far around the period; those of another seed would not."""
    family, seeds = parse_world(LONG_OR_SHORT), np.arange(12, dtype=np.uint64)
    together = Simulation(family, reference_contract(), seeds)
    alone = [
        Simulation(family.drawn(int(s)), reference_contract(), seeds[s : s + 1]) for s in seeds
    ]
    assert any(one.params.world.layers["has_belt"][0, 0] for one in alone)
    assert not together.params.world.layers["has_belt"].any()
    for agent, one in enumerate(alone):
        near, wanted = within_reach(together, agent), within_reach(one, 0)
        assert len(near) > 0
        np.testing.assert_allclose(near, wanted, atol=1e-5)


def within_reach(simulation: Simulation, agent: int) -> npt.NDArray[np.float64]:
    """Middles of the obstacles that an agent may see, in order; a list may hold more: (n, 2)."""
    range_m = simulation.contract.retina.range_m
    x_m, y_m = simulation.x_m[agent], simulation.y_m[agent]
    near = simulation.outlines_near(agent)
    middles = sorted((o.x_m, o.y_m) for o in near)
    return np.array([m for m in middles if math.dist(m, (x_m, y_m)) < range_m]).reshape(-1, 2)


SLOW_OR_FAST = """
name = "slow or fast"
[[layers]]
kind = "scatter"
density_per_m2 = 0.2
motion = { kind = "drift", ahead_mps = { from = -20.0, to = -1.0 } }
"""


def test_an_agent_takes_nothing_along_from_a_world_with_a_longer_belt() -> None:
    family, one = parse_world(SLOW_OR_FAST), np.zeros(1, np.int64)
    fast, slow = np.array([8], np.uint64), np.array([2], np.uint64)
    moved = Simulation(family, reference_contract(), fast)
    columns = np.count_nonzero(moved.params.agents.belt_counts)
    fresh = Simulation(family, reference_contract(), slow)
    assert np.count_nonzero(fresh.params.agents.belt_counts) < columns
    moved.place(one, slow)
    for _ in range(60):
        assert moved.step_and_sense(one) == fresh.step_and_sense(one)
        assert moved.stacks.tobytes() == fresh.stacks.tobytes()
        middles = [[(o.x_m, o.y_m) for o in s.outlines_near(0)] for s in (moved, fresh)]
        assert middles[0] == middles[1]


def test_what_compiles_a_part_on_its_own_is_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    done: list[str] = []

    @contextmanager
    def alone(what: str) -> Iterator[None]:
        done.append(what)
        yield

    monkeypatch.setattr(step_compilation, "compiling_alone", alone)
    monkeypatch.setattr(step_compilation, "_others", {})
    contract = reference_contract()
    params = Simulation(World("plain"), contract, np.zeros(1, np.uint64)).params
    done.clear()
    for _ in range(2):
        step_compilation.cover_for(params, motions_of(contract))
        step_compilation.cast_for(params, motions_of(contract))
    assert done == ["cover", "cast"]


def test_what_holds_addresses_is_not_copied() -> None:
    held = Simulation(World("plain"), reference_contract(), np.zeros(1, np.uint64)).held_step()[1]
    with pytest.raises(TypeError, match="Struct: expected to stay where its address is"):
        pickle.dumps(held)
