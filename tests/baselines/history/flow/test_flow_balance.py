"""Flow balance in the bees' corridor, 4 m wide: positions to the left of its middle."""

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest

from reflexarc_baselines.history.flow.flow_balance import (
    FlowBalance,
    FlowBalanceAlways,
    FlowCorrelator,
    FlowLargest,
)
from reflexarc_baselines.history.flow.optic_flow import flow_contract
from reflexarc_baselines.registry import baseline_named
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import RandomPolicy
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.layers import Corridor
from reflexarc_sim_bridge.worlds.world import World
from support.grating import corridor as seen_corridor
from support.grating import two_frames
from support.ranges_seen import unremembered

WIDTH_M, AGENTS, STEPS, SETTLED = 4.0, 8, 1500, 300


def corridor(**walls: Any) -> World:
    world = world_named("bees")
    assert isinstance(world, World)
    (between,) = world.layers
    assert isinstance(between, Corridor)
    return replace(world, layers=(replace(between, **walls),))


def driven(policy: Any, world: World) -> tuple[float, float, int]:
    """Mean and spread of the positions once settled, and how often a wall was touched."""
    simulation = Simulation(world, policy.contract, np.arange(AGENTS, dtype=np.uint64))
    pilot = Pilot(policy, policy.contract, AGENTS, simulation.dt_s)
    places_m = []
    for step in range(STEPS):
        simulation.sense()
        pilot.begin_anew(simulation.step(pilot.act(simulation.stacks)))
        if step >= SETTLED:
            places_m.append(simulation.y_m)
    return float(np.mean(places_m)), float(np.std(places_m)), int(simulation.contacts.sum())


@cache
def place_m(name: str, **walls: float) -> float:
    return driven(baseline_named(name), corridor(**walls))[0]


CENTRING = ["flow-balance", "flow-balance-always", "flow-largest"]


@pytest.mark.parametrize("name", [*CENTRING, "flow-correlator"])
def test_between_equal_walls_it_flies_in_the_middle(name: str) -> None:
    assert abs(place_m(name)) < 0.1 * WIDTH_M


@pytest.mark.parametrize("name", [*CENTRING, "flow-correlator"])
def test_a_wall_that_moves_along_draws_it_nearer(name: str) -> None:
    """By theory d_left / d_right = 1 − 0.5, so W/6 = 0.67 m."""
    assert 0.05 * WIDTH_M < place_m(name, left_wall_mps=0.5) < 0.25 * WIDTH_M


def test_half_the_contrast_of_a_wall_leaves_gradients_in_the_middle_and_correlators_not() -> None:
    """The known fault of correlators: half the contrast is a quarter of the response."""
    assert abs(place_m("flow-balance", left_contrast=0.5)) < 0.1 * WIDTH_M
    assert place_m("flow-correlator", left_contrast=0.5) > 0.15 * WIDTH_M


def test_a_fast_body_that_always_looks_runs_to_and_fro_by_its_own_sidesteps() -> None:
    fast = replace(flow_contract(), actions=sideways_actions(1.0, 1.0))
    _, always_m, touches_always = driven(FlowBalanceAlways(drives_by=fast), corridor())
    _, on_stay_m, touches_on_stay = driven(FlowBalance(drives_by=fast), corridor())
    assert always_m > 1.5 * on_stay_m
    assert touches_always > 0 == touches_on_stay


def frames(aside_m: float, speeds: float = 1.0) -> Any:
    """Two frames beside the walls of a grating, nearer to the left one by so much."""
    before, now = (seen_corridor(x_m, aside_m, 2.0) for x_m in (0.0, 0.1 * speeds))
    return two_frames(before, now)


@pytest.mark.parametrize("policy", [FlowBalance(), FlowLargest(front_rad=1.2, kappa=0.05)])
@pytest.mark.parametrize(("aside_m", "winner"), [(0.5, 2), (-0.5, 1)])
def test_it_steps_away_from_the_nearer_wall_but_only_after_it_stayed(
    policy: FlowBalance, aside_m: float, winner: int
) -> None:
    memory, decided = unremembered(policy.contract), []
    for _ in range(5):
        _, winners, memory = policy.decide(frames(aside_m), memory)
        decided.append(int(winners[0]))
    assert decided == [0, winner, 0, winner, 0]


def test_what_always_looks_remembers_nothing() -> None:
    assert FlowBalanceAlways().contract.state.size == 0
    assert FlowBalanceAlways().decide(frames(0.5))[1].tolist() == [2]


def test_a_flow_of_nothing_or_of_the_same_on_both_sides_is_no_reason_to_step() -> None:
    blank = np.zeros((1, 2, 1, 16, 1), np.uint8)
    for retinas in (blank, frames(0.0)):
        assert FlowBalanceAlways().decide(retinas)[1].tolist() == [0]


def test_the_largest_flow_is_that_of_one_ray_within_the_front() -> None:
    """The first ray, at 84°, looks aside: the fastest there is none of the front's."""
    policy = FlowLargest(front_rad=0.8, kappa=1e-4)
    flow = np.array([[9.0, *6 * [1.0], 2.0, 5.0, *7 * [1.0]]], np.float32)
    left, right = policy.summed(flow)
    assert (left[0], right[0]) == (2.0, 5.0)


def test_the_memory_has_room_for_each_ray_of_any_eye() -> None:
    wide = replace(flow_contract(), retina=replace(flow_contract().retina, rays=32))
    policy = FlowCorrelator(drives_by=wide)
    seen = np.zeros((3, 2, 1, 32, 1), np.uint8)
    _, _, memory = policy.decide(seen, unremembered(policy.contract, 3))
    assert memory.shape == (3, policy.contract.state.size) == (3, 2 + 2 * 32)


@pytest.mark.parametrize("name", [*CENTRING, "flow-correlator"])
def test_at_home_it_touches_no_wall_and_random_motion_does(name: str) -> None:
    policy, home = baseline_named(name), world_named(baseline_named(name).ORIGIN.home_world)
    random = measure(RandomPolicy(1), flow_contract(), agents=128, steps=200, world=home)
    assert measure(policy, policy.contract, agents=128, steps=200, world=home).contacts == 0
    assert random.contacts > 5
