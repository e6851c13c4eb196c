import dataclasses
import itertools
import math
import re

import numba
import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_runtime.contract import Action, PolicyContract, RetinaSpec
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.retina import Scan, retina_from_scan
from reflexarc_sim_bridge.reference_field import reference_contract
from reflexarc_sim_bridge.seeds import test_seeds, validation_seeds
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.world_files import world_named
from reflexarc_sim_bridge.worlds import Scanner

REFERENCE = world_named("reference-1")
CONTRACT = PolicyContract()


def drive(simulation: Simulation, steps: int, seed: int = 0) -> bytes:
    """All retinas, contacts and places of a random drive, as bytes."""
    generator, seen = np.random.default_rng(seed), []
    for _ in range(steps):
        seen.append(simulation.sense().tobytes())
        met = simulation.step(generator.integers(0, 3, len(simulation)))
        seen += [met.tobytes(), simulation.x_m.tobytes(), simulation.y_m.tobytes()]
    return b"".join(seen)


def test_the_same_seeds_give_the_same_bits() -> None:
    first, second = (Simulation(REFERENCE, CONTRACT, test_seeds(32)) for _ in range(2))
    assert drive(first, 200) == drive(second, 200)


@pytest.mark.skipif(numba.get_num_threads() < 2, reason="needs two threads")
def test_one_thread_and_two_give_the_same_bits() -> None:
    drives = []
    for threads in (1, 2):
        numba.set_num_threads(threads)
        drives.append(drive(Simulation(REFERENCE, CONTRACT, test_seeds(33)), 60))
    numba.set_num_threads(1)
    assert drives[0] == drives[1]


def test_what_an_agent_does_depends_on_no_other_agent() -> None:
    seeds = test_seeds(20)
    together = Simulation(REFERENCE, CONTRACT, seeds)
    alone = Simulation(REFERENCE, CONTRACT, seeds[7:8])
    for action in itertools.islice(itertools.cycle([0, 1, 0, 2, 2]), 150):
        together.step(np.full(20, action))
        alone.step(np.full(1, action))
    assert (together.x_m[7], together.y_m[7]) == (alone.x_m[0], alone.y_m[0])
    np.testing.assert_array_equal(together.sense()[7], alone.sense()[0])


def test_agents_of_one_world_start_apart() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, validation_seeds(1500))
    assert len(np.unique(simulation.y_m)) == 1500


def test_a_restored_state_goes_on_to_the_same_bits() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(16))
    drive(simulation, 50)
    state = simulation.state()
    ahead = drive(simulation, 120, seed=1)
    other = Simulation(REFERENCE, CONTRACT, test_seeds(40)[24:])
    other.restore(state)
    assert drive(other, 120, seed=1) == ahead


def test_a_state_is_a_copy() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(4))
    state = simulation.state()
    before = {name: array.copy() for name, array in state.items()}
    drive(simulation, 30)
    assert all(np.array_equal(state[name], before[name]) for name in state)


def test_a_state_of_another_form_is_refused_and_changes_nothing() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(4))
    state, x_m = Simulation(REFERENCE, CONTRACT, test_seeds(5)).state(), simulation.x_m.copy()
    with pytest.raises(WorldError, match=re.escape("state.x_m: expected float64 (4,), got")):
        simulation.restore(state)
    with pytest.raises(WorldError, match=r"state\.x_m: expected .*, got nothing"):
        simulation.restore({})
    np.testing.assert_array_equal(simulation.x_m, x_m)


def test_a_retina_has_the_contract_s_shape() -> None:
    contract = PolicyContract(retina=RetinaSpec(rays=24))
    retinas = Simulation(REFERENCE, contract, test_seeds(5)).sense()
    assert retinas.shape == (5, 1, 24, 1)
    assert retinas.dtype == np.uint8


@pytest.mark.parametrize(
    ("contract", "where"),
    [
        (PolicyContract(retina=RetinaSpec(eyes=2, baseline_m=0.1)), "retina.eyes"),
        (PolicyContract(retina=RetinaSpec(channels=3)), "retina.channels"),
        (PolicyContract(retina=RetinaSpec(frames=2)), "retina.frames"),
        (PolicyContract(actions=(Action("a", 1, 0, 0.5), Action("b", 1, 0))), "actions"),
        (PolicyContract(actions=(Action("a", 1, 0), Action("b", 2, 0))), "actions"),
    ],
)
def test_what_is_not_supported_is_refused_by_name(contract: PolicyContract, where: str) -> None:
    with pytest.raises(WorldError, match=rf"^contract\.{re.escape(where)}: the simulator supports"):
        Simulation(REFERENCE, contract, test_seeds(2))


@pytest.mark.parametrize(
    "actions",
    [np.zeros(3, np.int64), np.zeros(4, np.int32), np.full(4, 3), np.full(4, -1)],
)
def test_actions_that_cannot_be_are_refused(actions: npt.NDArray[np.int64]) -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(4))
    with pytest.raises(WorldError, match=r"^actions: expected"):
        simulation.step(actions)


@pytest.mark.parametrize(
    "seeds", [np.zeros(3, np.int64), np.zeros((2, 2), np.uint64), np.zeros(0, np.uint64)]
)
def test_seeds_that_cannot_be_are_refused(seeds: npt.NDArray[np.uint64]) -> None:
    with pytest.raises(WorldError, match=r"^seeds: expected uint64"):
        Simulation(REFERENCE, CONTRACT, seeds)


def test_obstacles_for_drawing_hold_what_the_rays_meet() -> None:
    world = dataclasses.replace(world_named("mixed"), colour=(0.3, 0.9))
    simulation = Simulation(world, CONTRACT, test_seeds(3))
    near = simulation.obstacles_near(1)
    assert len(near) > 10
    assert set(np.unique(near["round"])) == {False, True}
    assert near["colour"].min() >= 0.3
    assert near["colour"].max() <= 0.9
    assert (np.abs(near["y_m"] - simulation.y_m[1]) < 9.0).all()


def test_a_narrow_period_shows_its_obstacles_again() -> None:
    narrow = dataclasses.replace(REFERENCE, width_m=4.0)
    simulation = Simulation(narrow, CONTRACT, test_seeds(3))
    near = simulation.obstacles_near(0)
    again = near[np.isclose(near["x_m"], near["x_m"][0])]
    assert len(again) >= 3
    np.testing.assert_allclose(np.diff(np.sort(again["y_m"])), 4.0)


def test_a_wholly_blocked_line_lets_the_agent_through_without_counting_the_way() -> None:
    crowded = dataclasses.replace(REFERENCE, width_m=1.5, density_per_m2=2.0)
    simulation = Simulation(crowded, CONTRACT, test_seeds(64))
    for _ in range(300):
        simulation.step(np.zeros(64, np.int64))
    assert np.isfinite(simulation.y_m).all()
    assert (simulation.x_m > simulation.distance_m + 0.05).any()
    assert (simulation.x_m > 5.0).all()


def test_a_hundred_thousand_steps_stay_finite() -> None:
    simulation = Simulation(REFERENCE, CONTRACT, test_seeds(2))
    generator = np.random.default_rng(0)
    for _ in range(50_000):
        simulation.step(generator.integers(0, 3, 2))
    agents = simulation.params.agents
    assert all(np.isfinite(array).all() for array in agents)
    assert (simulation.x_m > 4000.0).all()
    assert ((simulation.y_m >= 0.0) & (simulation.y_m <= 20.0)).all()
    assert (agents.near_count < agents.near.shape[2]).all()


def test_behind_a_scanner_the_eye_sees_what_the_runtime_takes_from_the_sweep():
    """181 rays over 181° stand at the beams of a sweep of 181 beams over 180°."""
    seeds, scanner = test_seeds(64), Scanner()
    every_beam = RetinaSpec(rays=181, fov_rad=math.pi * 181 / 180, range_m=5.0)
    sweeping = Simulation(world_named("reference-1"), reference_contract(every_beam), seeds)
    behind = Simulation(world_named("scanned"), reference_contract(), seeds)
    seen = behind.sense()
    sweeping.sense()
    for agent in range(64):
        leftmost_first = sweeping.params.agents.ray_distance_m[agent].astype(np.float64)
        scan = Scan(scanner.start_rad, -scanner.start_rad, leftmost_first[::-1])
        expected = retina_from_scan(scan, reference_contract().retina)
        assert np.abs(seen[agent].astype(int) - expected.astype(int)).max() <= 1  # float32 bearings


def test_a_scanner_that_does_not_cover_the_eye_is_refused():
    narrow = dataclasses.replace(world_named("scanned"), scanner=Scanner(91, math.pi / 2))
    with pytest.raises(WorldError, match="covers the field of view"):
        Simulation(narrow, reference_contract(), test_seeds(1))


def test_one_agent_alone_does_to_the_bit_what_it_does_among_many():
    seeds = test_seeds(5)
    crowd, alone = (
        Simulation(REFERENCE, CONTRACT, seeds),
        Simulation(REFERENCE, CONTRACT, seeds[3:4]),
    )
    generator = np.random.default_rng(0)
    for _ in range(300):
        assert crowd.sense()[3].tobytes() == alone.sense()[0].tobytes()
        actions = generator.integers(0, 3, 5)
        assert crowd.step(actions)[3] == alone.step(actions[3:4])[0]
        assert (crowd.x_m[3], crowd.y_m[3]) == (alone.x_m[0], alone.y_m[0])
