"""Room that agents of whole worlds have, against what happens when they really go straight on."""

from collections.abc import Iterator

import numpy as np
import pytest

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action, sideways_actions
from reflexarc_sim_bridge.native import threads
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.surroundings import AgentSurroundings
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.seeds import validation_seeds
from reflexarc_sim_bridge.worlds.world import World
from support.slow_geometry import clearances_m
from support.slow_world import outlines_around

RANGE_M = 3.0
TURNING = (Action("ahead", 1.0, 0.0), Action("turn", 1.0, 0.0, 1.0))
TURNER = PolicyContract(retina=RetinaSpec(rays=16, range_m=RANGE_M), actions=TURNING)
SIDESTEPPER = PolicyContract(
    retina=RetinaSpec(rays=16, range_m=RANGE_M), actions=sideways_actions()
)
AT_REST = "reference-1", "turned", "polygons", "stars", "discs", "gates", "corridor-10", "wide"
MOVING = "crossing", "oncoming", "crowd", "swing"


def measured(surroundings: AgentSurroundings, agents: int) -> tuple[np.ndarray, np.ndarray]:
    clearance_m, ahead_s = np.empty(agents, np.float32), np.empty(agents, np.float32)
    surroundings.measure(clearance_m, ahead_s)
    return clearance_m, ahead_s


def scattered(name: str, agents: int, contract: PolicyContract) -> Simulation:
    """Agents that have gone a while, each on its own way."""
    simulation = Simulation(world_named(name), contract, validation_seeds(agents), all_round=True)
    generator = np.random.default_rng(5)
    for _ in range(
        85 if (name, contract) == ("gates", SIDESTEPPER) else 25
    ):  # up to the first gate
        simulation.step(generator.integers(0, len(contract.actions), agents))
    return simulation


def met_after_s(simulation: Simulation, until_s: float) -> np.ndarray:
    """When each agent first meets something on its way straight on: (n,), infinity if never."""
    agents, found_s = len(simulation), np.full(len(simulation), np.inf)
    cos = np.cos(simulation.heading_rad)
    for step in range(int(until_s / simulation.dt_s) + 1):
        before_m = simulation.distance_m.copy()
        met = simulation.step(np.zeros(agents, np.int64)) & np.isinf(found_s)
        part_s = (simulation.distance_m - before_m) / cos
        found_s[met] = step * simulation.dt_s + part_s[met]
    return found_s


@pytest.mark.parametrize("contract", [SIDESTEPPER, TURNER])
@pytest.mark.parametrize("name", AT_REST)
def test_among_things_at_rest_time_ahead_is_when_an_agent_meets_them(
    name: str, contract: PolicyContract
) -> None:
    simulation = scattered(name, 96, contract)
    ahead_s = measured(AgentSurroundings(simulation), 96)[1]
    horizon_s = RANGE_M - simulation.world.drawn(0).chassis.radius_m
    met_s = met_after_s(simulation, horizon_s)
    met_s[met_s > horizon_s + 1e-4] = np.inf
    clear = np.abs(met_s - horizon_s) > 1e-4
    assert np.isfinite(met_s).sum() > 5
    np.testing.assert_allclose(ahead_s[clear], met_s[clear], atol=1e-4)


@pytest.mark.parametrize("name", MOVING)
def test_among_moving_things_an_agent_meets_what_the_time_ahead_says(name: str) -> None:
    """For so long nothing comes that was out of range, at speeds of up to 1.5 m/s together."""
    simulation = scattered(name, 192, SIDESTEPPER)
    ahead_s = measured(AgentSurroundings(simulation), 192)[1]
    met_s, soon = met_after_s(simulation, 1.6), ahead_s < 1.5
    assert soon.sum() > 20
    np.testing.assert_allclose(met_s[soon], ahead_s[soon], atol=0.03 if name == "swing" else 1e-4)
    assert (met_s[~soon] > 1.5 - 0.03).all()


@pytest.mark.parametrize("name", [*AT_REST, *MOVING, "automaton"])
def test_clearance_is_that_of_all_obstacles_of_the_chunks_around(name: str) -> None:
    simulation = scattered(name, 12, SIDESTEPPER)
    clearance_m = measured(AgentSurroundings(simulation), 12)[0]
    for agent in range(12):
        place_m = np.array([[simulation.x_m[agent], simulation.y_m[agent]]])
        around = outlines_around(simulation, agent, RANGE_M)
        away_m = float(np.min(clearances_m(around, place_m), initial=RANGE_M))
        radius_m = simulation.world.drawn(0).chassis.radius_m
        assert clearance_m[agent] == pytest.approx(max(away_m - radius_m, 0.0), abs=2e-5)


@pytest.fixture
def any_threads() -> Iterator[None]:
    before = threads.thread_count()
    yield
    threads.set_thread_count(before)


@pytest.mark.usefixtures("any_threads")
def test_the_bits_are_the_same_on_any_number_of_threads() -> None:
    simulation = scattered("crowd", 300, SIDESTEPPER)
    surroundings, found = AgentSurroundings(simulation), []
    for count in (1, 2, 4):
        threads.set_thread_count(count)
        found.append([values.tobytes() for values in measured(surroundings, 300)])
    assert found[0] == found[1] == found[2]


@pytest.mark.parametrize("name", ["reference-1", "crowd", "randomised", "automaton"])
def test_near_lists_all_round_change_nothing_that_agents_see_or_meet(name: str) -> None:
    seen = []
    for all_round in (False, True):
        simulation = Simulation(
            world_named(name), SIDESTEPPER, validation_seeds(24), all_round=all_round
        )
        generator = np.random.default_rng(3)
        for _ in range(60):
            seen.append((all_round, simulation.sense().tobytes()))
            simulation.step(generator.integers(0, 3, 24))
        simulation.place(np.arange(8), validation_seeds(16)[8:])
        seen.append((all_round, simulation.sense().tobytes()))
    half = len(seen) // 2
    assert [each for _, each in seen[:half]] == [each for _, each in seen[half:]]


def test_to_measure_disturbs_nothing() -> None:
    simulation = scattered("noisy", 8, SIDESTEPPER)
    before = {name: array.tobytes() for name, array in simulation.state().items()}
    measured(AgentSurroundings(simulation), 8)
    assert {name: array.tobytes() for name, array in simulation.state().items()} == before


def test_a_simulation_that_forgets_what_lies_behind_is_refused() -> None:
    simulation = Simulation(World("plain"), SIDESTEPPER, validation_seeds(2))
    with pytest.raises(AssertionError, match="all_round"):
        AgentSurroundings(simulation)
