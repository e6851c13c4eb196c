from dataclasses import replace

import numpy as np
import pytest

from reflexarc_baselines.history.viewing_directions import ViewingDirections
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

SEEDS = validation_seeds(128)


def test_it_meets_far_less_than_an_agent_that_never_steers() -> None:
    """And so than one that steers at random, which meets more."""
    agent = ViewingDirections()
    ours = measure(agent, agent.contract, agents=128, steps=200, seeds=SEEDS)
    blind = measure(BlindPolicy(), reference_contract(), agents=128, steps=200, seeds=SEEDS)
    assert ours.contacts_per_100m < 0.85 * blind.contacts_per_100m


def test_weights_of_the_other_sign_steer_into_obstacles() -> None:
    right = ViewingDirections()
    detectors = right.detectors
    wrong = replace(
        right, detectors=replace(detectors, weights=tuple(-w for w in detectors.weights))
    )
    rates = [
        measure(each, each.contract, agents=64, steps=200, seeds=SEEDS[:64]).contacts_per_100m
        for each in (right, wrong)
    ]
    assert rates[1] > 1.5 * rates[0]


def test_time_constants_are_seconds_at_any_rate() -> None:
    """A step of brightness, 0.4 s ago: at 10 and at 50 Hz the slow mean has gone as far."""
    fading = []
    for period_s, looks in ((0.1, 5), (0.02, 21)):
        agent = replace(ViewingDirections(), period_s=period_s)
        memories = np.zeros((1, agent.contract.state.size), np.float32)
        shape = (1, *agent.eye.stack_shape)
        _, _, memories = agent.decide(np.zeros(shape, np.uint8), memories)
        for _ in range(looks - 1):
            _, _, memories = agent.decide(np.full(shape, 255, np.uint8), memories)
        fading.append(memories[0, 0])
    assert fading[0] == pytest.approx(fading[1], rel=1e-5)
