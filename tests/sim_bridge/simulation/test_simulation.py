import dataclasses
import itertools
import pickle
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import WorldError
from reflexarc_sim_bridge.native import threads
from reflexarc_sim_bridge.simulation.simulation import Simulation, motions_of
from reflexarc_sim_bridge.worlds.files import parse_world
from reflexarc_sim_bridge.worlds.layers import Automaton, Corridor, Drift, Gates, Scatter, Swing
from reflexarc_sim_bridge.worlds.seeds import test_seeds, validation_seeds
from reflexarc_sim_bridge.worlds.shapes import Curves, Discs, Polygons, Rectangles
from reflexarc_sim_bridge.worlds.world import AfterContact, Chassis, Edges, Scanner, Senses, World
from support.drawn_worlds import TURNING

REFERENCE = World("reference")
CONTRACT = PolicyContract()
WORLDS = {
    "reference": REFERENCE,
    "shapes": World(
        "s",
        layers=(
            Scatter(0.1, (Discs(), Polygons(dent=(0.0, 0.5), corners=(5, 9)))),
            Scatter(0.1, (Curves(), Rectangles(turned_rad=(0.0, 1.0))), gap_m=1.0),
        ),
        chassis=Chassis(radius_m=0.2, slip=0.1, lag_s=0.2, acceleration_mps2=5.0),
    ),
    "moving": World(
        "m",
        layers=(Scatter(0.1, motion=Drift(-1.0, 0.3)), Scatter(0.1, (Discs(),), motion=Swing())),
        senses=Senses(noise=0.02, dropout=0.05, latency_s=0.2),
    ),
    "gates": World("g", layers=(Gates(), Scatter(0.05, sections=(0.0, 2.0)))),
    "corridor": World("c", edges=Edges.UNBOUNDED, layers=(Corridor(), Scatter(0.1))),
    "striped": World(
        "b",
        edges=Edges.UNBOUNDED,
        layers=(
            Corridor(5.0, 1.0, colour=((0.0, 1.0),), stripes_m=0.5, left_wall_mps=0.5),
            Scatter(0.1, (Rectangles(), Discs()), colour=((0.2, 1.0),), stripes_m=0.3),
        ),
    ),
    "automaton": World("a", layers=(Automaton(fill=0.3),)),
    "ghosts": World("h", chassis=Chassis(after_contact=AfterContact.GHOST)),
    "open": World("o", width_m=12.0, edges=Edges.OPEN, scanner=Scanner()),
}


def drive(simulation: Simulation, steps: int, seed: int = 0) -> bytes:
    """All retinas, contacts and places of a random drive, as bytes."""
    generator, seen = np.random.default_rng(seed), []
    for _ in range(steps):
        seen.append(simulation.sense().tobytes())
        met = simulation.step(generator.integers(0, 3, len(simulation)))
        seen += [met.tobytes(), simulation.x_m.tobytes(), simulation.y_m.tobytes()]
    return b"".join(seen)


def contract_of(name: str) -> PolicyContract:
    return CONTRACT if name == "open" else PolicyContract(actions=TURNING)


# The same bits


@pytest.mark.parametrize("name", WORLDS)
def test_the_same_seeds_give_the_same_bits_on_one_thread_and_two(name: str) -> None:
    before, drives = threads.thread_count(), []
    try:
        for count in (1, 1, 2, 3):
            threads.set_thread_count(count)
            drives.append(drive(Simulation(WORLDS[name], contract_of(name), test_seeds(200)), 40))
    finally:
        threads.set_thread_count(before)
    assert drives[1:] == drives[:1] * 3


@pytest.mark.parametrize("name", WORLDS)
def test_what_an_agent_does_depends_on_no_other_agent(name: str) -> None:
    seeds = test_seeds(5)
    crowd = Simulation(WORLDS[name], contract_of(name), seeds)
    alone = Simulation(WORLDS[name], contract_of(name), seeds[3:4])
    generator = np.random.default_rng(0)
    for _ in range(150):
        assert crowd.sense()[3].tobytes() == alone.sense()[0].tobytes()
        actions = generator.integers(0, 3, 5)
        assert crowd.step(actions)[3] == alone.step(actions[3:4])[0]
        assert (crowd.x_m[3], crowd.y_m[3]) == (alone.x_m[0], alone.y_m[0])


@pytest.mark.parametrize("name", WORLDS)
def test_a_restored_state_goes_on_to_the_same_bits(name: str) -> None:
    simulation = Simulation(WORLDS[name], contract_of(name), test_seeds(16))
    drive(simulation, 50)
    state = simulation.state()
    ahead = drive(simulation, 80, seed=1)
    other = Simulation(WORLDS[name], contract_of(name), test_seeds(40)[24:])
    other.restore(state)
    assert drive(other, 80, seed=1) == ahead


def test_step_and_sense_is_a_step_and_a_look() -> None:
    both, one = (Simulation(REFERENCE, CONTRACT, test_seeds(70)) for _ in range(2))
    for action in itertools.islice(itertools.cycle([0, 1, 0, 2, 2]), 60):
        actions = np.full(70, action)
        np.testing.assert_array_equal(one.step_and_sense(actions), both.step(actions))
        np.testing.assert_array_equal(one.stacks[:, -1], both.sense())


@pytest.mark.parametrize("name", WORLDS)
def test_placed_agents_begin_as_in_a_simulation_of_their_own(name: str) -> None:
    simulation = Simulation(WORLDS[name], contract_of(name), test_seeds(6))
    drive(simulation, 40)
    others = simulation.state()["state"][[0, 2, 3, 5]]
    new = validation_seeds(2)
    simulation.place(np.array([1, 4]), new)
    np.testing.assert_array_equal(simulation.state()["state"][[0, 2, 3, 5]], others)
    fresh = Simulation(WORLDS[name], contract_of(name), new)
    assert (simulation.distance_m[[1, 4]] == 0.0).all()
    for _ in range(40):
        np.testing.assert_array_equal(simulation.sense()[[1, 4]], fresh.sense())
        met = simulation.step(np.array([0, 1, 2, 0, 2, 1]))[[1, 4]]
        np.testing.assert_array_equal(met, fresh.step(np.array([1, 2])))
    np.testing.assert_array_equal(simulation.x_m[[1, 4]], fresh.x_m)


def test_nobody_placed_is_nothing_done() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(3))
    state = simulation.state()
    simulation.place(np.zeros(0, np.int64), np.zeros(0, np.uint64))
    assert all(np.array_equal(state[k], v) for k, v in simulation.state().items())


def test_agents_of_one_world_start_apart() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, validation_seeds(1500))
    assert len(np.unique(simulation.y_m)) == 1500
    assert (simulation.x_m == 0.0).all()


def test_a_state_is_a_copy() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(4))
    state = simulation.state()
    before = {name: array.copy() for name, array in state.items()}
    drive(simulation, 30)
    assert all(np.array_equal(state[name], before[name]) for name in state)


# Finite, for ever

AGENTS = 4096
STEPS = {
    "reference": 800,
    "shapes": 100,
    "moving": 300,
    "gates": 300,
    "corridor": 300,
    "striped": 100,
    "automaton": 60,
    "ghosts": 300,
    "open": 300,
}


def first_not_finite(simulation: Simulation) -> str | None:
    """Which number of the agents' is none, or has left its bounds."""
    agents, state = simulation.params.agents, simulation.params.agents.state
    for name in ("x_m", "y_m", "heading_rad", "distance_m", "linear_mps", "lateral_mps"):
        if not np.isfinite(state[name]).all():
            return name
    for name in ("boxes", "discs", "sides"):
        if not np.isfinite(np.sum(getattr(agents, name), dtype=np.float64)):
            return name
    side_m = simulation.params.world.planes["chunk_width_m"][state["world"]]
    if ((state["x_m"] < 0.0) | (state["x_m"] > 2.5)).any():
        return "x_m"
    return "y_m" if ((state["y_m"] < 0.0) | (state["y_m"] > side_m)).any() else None


@pytest.mark.parametrize("name", WORLDS)
def test_ten_million_steps_stay_finite(name: str) -> None:
    """4,096 agents in nine kinds of worlds, with and without turning."""
    assert AGENTS * sum(STEPS.values()) >= 10_000_000
    actions = (Action("a", 1.0, 0.5, 3.0), Action("b", 1.5, 0.0), Action("c", 0.5, -1.0, -4.0))
    eye = PolicyContract(retina=RetinaSpec(rays=2, range_m=0.5), actions=actions)
    simulation = Simulation(WORLDS[name], eye, test_seeds(AGENTS))
    generator = np.random.default_rng(0)
    for step in range(STEPS[name]):
        if step % 20 == 0:
            held = generator.integers(0, 3, AGENTS)
            assert first_not_finite(simulation) is None
            simulation.sense()
        simulation.step(held)
    assert first_not_finite(simulation) is None
    assert simulation.contacts.sum() > 1000


@pytest.mark.parametrize("name", ["x_m", "heading_rad", "linear_mps"])
def test_a_number_that_is_not_finite_is_found(name: str) -> None:
    simulation = Simulation(WORLDS["shapes"], contract_of("shapes"), test_seeds(64))
    assert first_not_finite(simulation) is None
    simulation.params.agents.state[name][17] = np.nan
    assert first_not_finite(simulation) == name
    near = Simulation(REFERENCE, CONTRACT, test_seeds(64))
    near.params.agents.boxes[3, 0, 1, 2] = np.inf
    assert first_not_finite(near) == "boxes"


# What is refused


def test_a_state_of_another_form_is_refused_and_changes_nothing() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(4))
    state, x_m = Simulation(REFERENCE, CONTRACT, test_seeds(5)).state(), simulation.x_m.copy()
    with pytest.raises(WorldError, match=r"^state\.state: expected .* \(4,\), got .* \(5,\)"):
        simulation.restore(state)
    with pytest.raises(WorldError, match=r"^state\.\w+: expected .*, got nothing"):
        simulation.restore({})
    np.testing.assert_array_equal(simulation.x_m, x_m)


def test_a_scanner_that_does_not_cover_the_eye_is_refused() -> None:
    narrow = dataclasses.replace(REFERENCE, scanner=Scanner(91, 1.5))
    with pytest.raises(WorldError, match=r"world\.scanner: .*cover.* the field of view"):
        Simulation(narrow, CONTRACT, test_seeds(1))


@pytest.mark.parametrize(
    "actions", [np.zeros(3, np.int64), np.zeros(4, np.int32), np.full(4, 3), np.full(4, -1)]
)
def test_actions_that_cannot_be_are_refused(actions: npt.NDArray[np.int64]) -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(4))
    for move in (simulation.step, simulation.step_and_sense):
        with pytest.raises(WorldError, match=r"^actions: expected"):
            move(actions)


@pytest.mark.parametrize(
    "seeds", [np.zeros(3, np.int64), np.zeros((2, 2), np.uint64), np.zeros(0, np.uint64)]
)
def test_seeds_that_cannot_be_are_refused(seeds: npt.NDArray[np.uint64]) -> None:
    with pytest.raises(WorldError, match=r"^seeds: expected uint64"):
        Simulation(REFERENCE, CONTRACT, seeds)


# Shapes of arrays


def test_a_retina_and_a_stack_have_the_contract_s_shapes() -> None:
    spec = RetinaSpec(rays=24, eyes=2, baseline_m=0.1, channels=3, frames=2)
    simulation = Simulation(REFERENCE, PolicyContract(retina=spec), test_seeds(5))
    retinas = simulation.sense()
    assert (retinas.shape, retinas.dtype) == ((5, 2, 24, 3), np.uint8)
    assert simulation.stacks.shape == (5, 2, 2, 24, 3)
    assert len(simulation) == 5


def test_motions_are_linear_lateral_angular() -> None:
    contract = PolicyContract(actions=(Action("a", 1.0, 2.0, 3.0), Action("b", 4.0, 5.0)))
    assert motions_of(contract).tolist() == [[1.0, 2.0, 3.0], [4.0, 5.0, 0.0]]


def test_a_named_number_of_threads_is_kept_until_told_otherwise() -> None:
    before = threads.thread_count()
    threads.set_thread_count(5)
    assert threads.thread_count() == 5
    threads.set_thread_count(before)
    assert re.fullmatch(r"\d+", str(threads.thread_count()))


ELSEWHERE = """
import pickle, sys
import numpy as np
with open(sys.argv[1], "rb") as file:
    simulation = pickle.load(file)
for _ in range(20):
    simulation.step_and_sense(np.ones(len(simulation), np.int64))
print(simulation.stacks.tobytes().hex())
"""


def test_a_copy_in_another_process_goes_on_as_this_one_does(tmp_path: Path) -> None:
    """Addresses of compiled code and of arrays stay behind."""
    simulation = Simulation(World("plain"), PolicyContract(actions=TURNING), test_seeds(3))
    simulation.step_and_sense(np.zeros(3, np.int64))
    path = tmp_path / "simulation.pickle"
    path.write_bytes(pickle.dumps(simulation))
    command = [sys.executable, "-c", ELSEWHERE, str(path)]
    there = subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    for _ in range(20):
        simulation.step_and_sense(np.ones(3, np.int64))
    assert there == simulation.stacks.tobytes().hex()


def test_a_step_lasts_as_long_as_those_of_the_agents_do_on_average() -> None:
    text = 'name = "quick"\ndt_s = { from = 0.05, to = 0.15 }\n[[layers]]\nkind = "scatter"\n'
    family, seeds = parse_world(text), np.arange(8, dtype=np.uint64)
    drawn_s = [family.drawn(seed).dt_s for seed in seeds.tolist()]
    assert len(set(drawn_s)) == 8
    assert Simulation(family, CONTRACT, seeds).dt_s == pytest.approx(sum(drawn_s) / 8)
    assert Simulation(REFERENCE, CONTRACT, seeds).dt_s == REFERENCE.dt_s
