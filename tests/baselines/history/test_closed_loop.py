from dataclasses import dataclass

import numpy as np

from reflexarc_baselines.history.closed_loop import BEARINGS_RAD, ClosedLoop
from reflexarc_runtime.arrays import Actions, Memories, QValues, RetinaBatch
from reflexarc_runtime.policy.policy import RememberingPolicy
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import validation_seeds

SEEDS = validation_seeds(128)


@dataclass(frozen=True)
class Yoked:
    """Every body does what the one beside it would do: action without its perception."""

    alone: ClosedLoop

    def decide(self, retinas: RetinaBatch, memories: Memories) -> tuple[QValues, Actions, Memories]:
        q_values, actions, following = self.alone.decide(retinas, memories)
        return np.roll(q_values, 1, axis=0), np.roll(actions, 1), following


def rate(policy: RememberingPolicy) -> float:
    score = measure(policy, ClosedLoop().contract, agents=128, steps=200, seeds=SEEDS)
    return score.contacts_per_100m


def test_it_looks_along_45_degrees() -> None:
    assert ClosedLoop().detectors.bearings_rad == BEARINGS_RAD


def test_it_avoids_in_its_loop_and_not_when_yoked_to_another_body() -> None:
    blind = measure(BlindPolicy(), reference_contract(), agents=128, steps=200, seeds=SEEDS)
    assert rate(ClosedLoop()) < 0.9 * blind.contacts_per_100m
    assert rate(Yoked(ClosedLoop())) > blind.contacts_per_100m
