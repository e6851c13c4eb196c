"""Wall following by flow in the bees' corridor."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from reflexarc_baselines.history.flow.flow_regulation import FlowRegulation
from reflexarc_baselines.history.flow.optic_flow import flow_contract
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

STEADY = FlowRegulation(kappa=0.02, smooth_s=1.0, dead_band=0.1)


def kept_m(policy: FlowRegulation, **walls: Any) -> float:
    """Median distance from the nearer wall, once settled."""
    world = world_named("bees")
    assert isinstance(world, World)
    (between,) = world.layers
    assert isinstance(between, Corridor)
    world = replace(world, layers=(replace(between, **walls),))
    simulation = Simulation(world, policy.contract, np.arange(16, dtype=np.uint64))
    pilot, found = Pilot(policy, policy.contract, 16, simulation.dt_s), []
    for step in range(900):
        simulation.sense()
        pilot.begin_anew(simulation.step(pilot.act(simulation.stacks)))
        if step >= 300:
            found.append(2.0 - np.abs(simulation.y_m))
    return float(np.median(found))


@pytest.mark.parametrize("wall_m", [1.3, 1.6])
def test_it_keeps_its_distance_from_the_wall_that_it_follows(wall_m: float) -> None:
    assert kept_m(replace(STEADY, wall_m=wall_m)) == pytest.approx(wall_m, rel=0.2)


def test_walls_that_move_along_at_half_of_its_speed_are_followed_at_half_of_the_distance() -> None:
    along = {"left_wall_mps": 0.5, "right_wall_mps": 0.5}
    assert kept_m(replace(STEADY, wall_m=2.0), **along) == pytest.approx(1.0, rel=0.25)


@pytest.mark.parametrize(
    ("aside_m", "wall_m", "winner"), [(0.3, 1.2, 2), (-0.3, 1.2, 1), (0.3, 0.4, 1), (-0.3, 0.4, 2)]
)
def test_it_steps_away_from_a_wall_that_is_too_near_and_towards_one_too_far(
    aside_m: float, wall_m: float, winner: int
) -> None:
    """The nearer wall, which it follows, is 0.7 m away; the other one 1.3 m."""
    policy = FlowRegulation(wall_m=wall_m, smooth_s=1e-3, kappa=0.001)
    seen = [
        two_frames(*(seen_corridor(x_m, aside_m, 2.0) for x_m in (from_m, from_m + 0.1)))
        for from_m in np.arange(40) / 20
    ]
    memory = np.ones_like(unremembered(policy.contract, len(seen)))  # they stayed
    q_values, _, _ = policy.decide(np.concatenate(seen), memory)
    wish = float(np.median(q_values[:, 1]))
    assert wish * (1 if winner == 1 else -1) > policy.dead_band


def test_its_mean_flow_follows_with_its_time_constant_and_only_when_it_looks() -> None:
    """Nothing moves any more: after τ of looks 1/e of the flow that it began with is left."""
    policy = FlowRegulation(smooth_s=1.0, period_s=0.1)
    still = np.full((1, 2, 1, 16, 1), 99, np.uint8)
    began = unremembered(policy.contract)
    assert began[0, 1:].tolist() == pytest.approx(2 * [policy.set_radps])
    _, _, memory = policy.decide(still, began)
    assert (memory[0, 1:] == began[0, 1:]).all()
    for _ in range(10):
        memory[0, 0] = 1.0
        _, _, memory = policy.decide(still, memory)
    assert memory[0, 1:].tolist() == pytest.approx(2 * [policy.set_radps / np.e], rel=1e-5)


def test_at_home_it_touches_walls_less_than_random_motion() -> None:
    policy, home = FlowRegulation(), world_named(FlowRegulation.ORIGIN.home_world)
    random = measure(RandomPolicy(1), flow_contract(), agents=128, steps=300, world=home)
    mine = measure(policy, policy.contract, agents=128, steps=300, world=home)
    assert mine.high < random.low
