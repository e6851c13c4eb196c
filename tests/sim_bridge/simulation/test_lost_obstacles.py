"""A list of obstacles that is full is an error, never a world with fewer obstacles."""

import re

import numpy as np
import pytest

from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.arrays.layout import LIST_NAMES
from reflexarc_sim_bridge.arrays.workspace import Faces, Workspace
from reflexarc_sim_bridge.environments.single import ReferenceEnv
from reflexarc_sim_bridge.environments.vector import ReferenceVectorEnv
from reflexarc_sim_bridge.native.intrinsics import LANES
from reflexarc_sim_bridge.native.threads import set_thread_count, thread_count
from reflexarc_sim_bridge.simulation import step_pointer
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.single_agent import OneAgent
from reflexarc_sim_bridge.worlds.files import WORLDS
from reflexarc_sim_bridge.worlds.layers import Automaton, Corridor, Gates, Layer, Scatter
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import Edges, World
from support.short_lists import shorten

DENSE = 1.5
TURNED = Rectangles(turned_rad=(0.0, 3.0))
SMALL_CURVES = Curves(radius_m=(0.2, 0.4))
SEED = 7
STANDING = np.zeros(1, np.int64)

FULL: dict[str, tuple[Layer, Edges, tuple[str, ...], int, str]] = {
    "boxes": (Scatter(DENSE, gap_m=0.1), Edges.PERIODIC, ("boxes",), 32, "boxes"),
    "turned": (Scatter(DENSE, (TURNED,), 0.1), Edges.PERIODIC, ("turned",), 32, "turned boxes"),
    "discs": (Scatter(0.8, (Discs(),)), Edges.PERIODIC, ("discs",), 32, "discs"),
    "sides": (Scatter(0.8, (Polygons(),)), Edges.PERIODIC, ("sides",), 64, "sides of polygons"),
    "curves": (Scatter(0.8, (SMALL_CURVES,)), Edges.PERIODIC, ("sides",), 64, "sides of polygons"),
    "gates": (Gates(spacing_m=2.5), Edges.PERIODIC, ("boxes",), 32, "boxes"),
    "automaton": (Automaton(fill=0.4), Edges.PERIODIC, ("boxes",), 32, "boxes"),
    "corridor": (Corridor(), Edges.UNBOUNDED, ("sides",), 32, "sides of polygons"),
    "picked from a belt": (Scatter(DENSE), Edges.PERIODIC, ("boxes",), 32, "boxes"),
    "turned on a belt": (
        Scatter(DENSE, (TURNED,)),
        Edges.PERIODIC,
        ("turned",),
        32,
        "turned boxes",
    ),
    "belt": (
        Scatter(DENSE),
        Edges.PERIODIC,
        ("belt_places", "belt_sizes"),
        32,
        "boxes on a belt",
    ),
}


def simulation_of(layer: Layer, edges: Edges = Edges.PERIODIC, agents: int = 1) -> Simulation:
    world = World("crowded", layers=(layer,), edges=edges)
    return Simulation(world, reference_contract(), np.full(agents, SEED, np.uint64))


def full(name: str) -> Simulation:
    layer, edges, lists, columns, _ = FULL[name]
    simulation = simulation_of(layer, edges)
    shorten(simulation, columns, *lists)
    return simulation


@pytest.mark.parametrize("name", FULL)
def test_a_step_that_finds_a_list_full_raises(name: str) -> None:
    *_, lists, columns, words = FULL[name]
    room = columns if "belt" in lists[0] else columns - LANES
    told = f"world 'crowded', seed {SEED}: expected room for all {words} near an agent, got "
    with pytest.raises(WorldError, match=re.escape(told) + rf"\d+ more than the {room} that fit"):
        full(name).step(STANDING)


def test_what_is_lost_is_counted() -> None:
    simulation, whole = full("discs"), simulation_of(FULL["discs"][0])
    with pytest.raises(WorldError) as told:
        simulation.step(STANDING)
    whole.params.agents.layer_cells[:] = 1 << 40
    whole.step(STANDING)
    lost = int(whole.params.agents.near_counts.sum()) - (32 - LANES)
    assert f"got {lost} more" in str(told.value)


def test_polygons_are_listed_whole_or_not_at_all() -> None:
    simulation = full("curves")
    with pytest.raises(WorldError):
        simulation.step(STANDING)
    assert simulation.params.agents.near_counts.max() == 48  # two curves of 24 sides


def test_an_error_is_told_once() -> None:
    simulation = full("discs")
    with pytest.raises(WorldError):
        simulation.step(STANDING)
    simulation.sense()


def with_few_faces(monkeypatch: pytest.MonkeyPatch) -> None:
    make = step_pointer.new_workspace

    def few(*arguments: object) -> Workspace:
        work: Workspace = make(*arguments)  # type: ignore[arg-type]
        return work._replace(faces=Faces(*(column[: 2 + LANES].copy() for column in work.faces)))

    monkeypatch.setattr(step_pointer, "new_workspace", few)


@pytest.mark.parametrize("shape", [TURNED, Polygons()])
def test_a_look_that_sees_too_many_faces_raises(
    shape: Rectangles | Polygons, monkeypatch: pytest.MonkeyPatch
) -> None:
    with_few_faces(monkeypatch)
    simulation = simulation_of(Scatter(0.6, (shape,)))
    with pytest.raises(WorldError, match=r"all faces near an agent, got \d+ more than the 2 that"):
        simulation.sense()
    with pytest.raises(WorldError, match="all faces near an agent"):
        simulation.look(0, 1)
    with pytest.raises(WorldError, match="all faces near an agent"):
        simulation.distances()
    with pytest.raises(WorldError, match="all faces near an agent"):
        OneAgent(simulation).sense()


def test_driving_by_hand_raises_too() -> None:
    with pytest.raises(WorldError, match="seed 7: expected room for all discs"):
        full("discs").drive(1.0, 0.0, 0.0)


def test_placing_raises_too() -> None:
    simulation = full("discs")
    with pytest.raises(WorldError, match="seed 3: expected room for all discs"):
        simulation.place(STANDING, np.array([3], np.uint64))


def test_the_step_of_one_agent_raises_too() -> None:
    agent = OneAgent(full("discs"))
    with pytest.raises(OverflowError, match="expected room for all obstacles near the agent"):
        agent.step_and_sense(0)
    with pytest.raises(WorldError, match="seed 7: expected room for all discs near an agent"):
        agent.require_nothing_lost()


@pytest.mark.parametrize("threads", [1, 2])
def test_every_thread_says_whose_list_it_was(threads: int) -> None:
    before = thread_count()
    set_thread_count(threads)
    try:
        simulation = simulation_of(Scatter(0.8, (Discs(),)), agents=200)
        simulation.params.agents.state["seed"] = np.arange(200)
        shorten(simulation, 32, "discs")
        with pytest.raises(WorldError, match=r"seed \d+: expected room for all discs"):
            simulation.step(np.zeros(200, np.int64))
    finally:
        set_thread_count(before)


CROWDED = World("crowded", layers=FULL["discs"][:1])


def test_a_gymnasium_environment_raises_it() -> None:
    environment = ReferenceEnv(world=CROWDED)
    environment.reset(seed=SEED)
    simulation = environment._agent.simulation
    shorten(simulation, 32, "discs")
    environment._agent = OneAgent(simulation)
    with pytest.raises(WorldError, match="seed 7: expected room for all discs near an agent"):
        environment.step(np.int64(0))
    with pytest.raises(WorldError, match="seed 8: expected room for all discs near an agent"):
        environment.reset(seed=8)


def test_a_vector_environment_raises_it() -> None:
    environments = ReferenceVectorEnv(3, world=CROWDED)
    environments.reset(seed=SEED)
    shorten(environments._simulation, 32, "discs")
    with pytest.raises(WorldError, match=r"seed \d+: expected room for all discs near an agent"):
        environments.step(np.zeros(3, np.int64))


@pytest.mark.parametrize("name", WORLDS)
def test_ordinary_worlds_lose_nothing(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[Workspace] = []
    make = step_pointer.new_workspace

    def noted(*arguments: object) -> Workspace:
        made.append(make(*arguments))  # type: ignore[arg-type]
        return made[-1]

    monkeypatch.setattr(step_pointer, "new_workspace", noted)
    simulation = Simulation(WORLDS[name], reference_contract(), np.arange(64, dtype=np.uint64))
    generator = np.random.default_rng(1)
    for _ in range(150):
        simulation.step_and_sense(generator.integers(0, 3, 64))
    assert sum(int(work.losses.counts.sum()) for work in made) == 0
    assert len(made[0].losses.counts) == len(LIST_NAMES)
