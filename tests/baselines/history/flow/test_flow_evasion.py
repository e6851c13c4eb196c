import math
from itertools import groupby

import numpy as np
import pytest

from reflexarc_baselines.history.flow.flow_evasion import FlowDivergence, FlowEmergency
from reflexarc_baselines.history.flow.optic_flow import flow_contract
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
from reflexarc_sim_bridge.worlds.files import world_named
from support.grating import bar, bearings_rad, two_frames
from support.ranges_seen import unremembered

Kind = type[FlowEmergency] | type[FlowDivergence]


def post(away_m: float, middle_m: float) -> RetinaBatch:
    """A bright face 0.5 m wide, its middle so far to the left, at 1 m/s; 0.1 s between frames."""
    shown = []
    for z_m in (away_m + 0.1, away_m):
        edges = [math.atan((middle_m + half_m) / z_m) for half_m in (0.25, -0.25)]
        shown.append(bar(edges[0], edges[1], 0.9, 0.0))
    return two_frames(*shown)


def winners_of(policy: FlowEmergency | FlowDivergence, *seen: RetinaBatch) -> list[int]:
    memory, found = unremembered(policy.contract), []
    for retinas in seen:
        _, winners, memory = policy.decide(retinas, memory)
        found.append(int(winners[0]))
    return found


@pytest.mark.parametrize(("middle_m", "winner"), [(0.1, 2), (-0.1, 1)])
def test_what_will_be_met_soon_is_evaded_away_from_its_middle(middle_m: float, winner: int) -> None:
    policy = FlowEmergency(urgent_s=1.5, evade_s=0.3, dead_band=1.5, front_rad=0.3)
    assert winners_of(policy, post(3.0, middle_m), post(2.0, middle_m)) == [0, 0]
    assert winners_of(policy, post(2.0, middle_m), post(1.0, middle_m)) == [0, winner]


@pytest.mark.parametrize(("period_s", "decisions"), [(0.1, 5), (0.05, 10)])
@pytest.mark.parametrize("kind", [FlowEmergency, FlowDivergence])
def test_an_evasion_goes_on_for_its_time_without_a_look_and_then_looks(
    kind: Kind, period_s: float, decisions: int
) -> None:
    policy = kind(evade_s=0.5, dead_band=1.5, period_s=period_s, front_rad=0.5)
    found = winners_of(policy, *(1 + 2 * decisions) * [post(0.7, -0.1)], *decisions * [post(4, 0)])
    runs = [(winner, len(list(group))) for winner, group in groupby(found)]
    assert runs[:3] == [(0, 1), (1, decisions), (0, 1)]


@pytest.mark.parametrize("away_m", [1.0, 2.0])
def test_divergence_before_a_flat_face_is_one_by_the_time_to_it(away_m: float) -> None:
    """F = (v/Z) sin φ cos φ, exactly; within ±0.5 rad the fit is 13 % short of v/Z at most."""
    bearings = bearings_rad(16)
    flow = (np.sin(bearings) * np.cos(bearings) / away_m).astype(np.float32)[np.newaxis]
    found = float(FlowDivergence(front_rad=0.5).divergence_radps(flow)[0])
    ahead = bearings[np.abs(bearings) <= 0.5]
    by_hand = (ahead * np.sin(ahead) * np.cos(ahead)).sum() / (ahead**2).sum() / away_m
    assert found == pytest.approx(by_hand, rel=1e-5)
    assert 0.87 / away_m < found < 1.0 / away_m


def test_turning_and_gliding_past_do_not_diverge() -> None:
    assert FlowDivergence().divergence_radps(np.full((1, 16), 0.7, np.float32))[0] == pytest.approx(
        0.0, abs=1e-6
    )


@pytest.mark.parametrize("kind", [FlowEmergency, FlowDivergence])
def test_at_home_it_beats_blind_and_random_motion(kind: Kind) -> None:
    policy, home = kind(), world_named(kind.ORIGIN.home_world)
    mine, blind, random = (
        measure(driver, contract, agents=256, steps=300, world=home)
        for driver, contract in (
            (policy, policy.contract),
            (BlindPolicy(), flow_contract()),
            (RandomPolicy(1), flow_contract()),
        )
    )
    assert mine.high < random.low
    assert mine.contacts_per_100m < blind.contacts_per_100m
