import math

import numpy as np
import pytest

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract, reference_retina
from reflexarc_sim_bridge.worlds.seeds import validation_seeds
from reflexarc_sim_bridge.worlds.world import World


class OpenSidePolicy:
    """Steers to the side that shows less, when something is ahead."""

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        values = retinas.reshape(len(retinas), -1).astype(np.float32)
        rays = values.shape[1]
        left, right = values[:, : rays // 2].sum(1), values[:, rays // 2 :].sum(1)
        ahead = values[:, rays // 2 - 2 : rays // 2 + 2].max(1) > 128
        q_values = np.stack([128.0 * ~ahead, right > left, left >= right], 1).astype(np.float32)
        return q_values, q_values.argmax(1)


def test_the_reference_eye_is_as_specified() -> None:
    eye = reference_retina()
    assert (eye.rays, eye.fov_rad, eye.range_m) == (16, math.pi, 5.0)
    assert (eye.shading, eye.frames, eye.eyes, eye.channels) == ("nearness", 1, 1, 1)
    speeds = [(a.name, a.linear_mps, a.lateral_mps) for a in reference_contract().actions]
    assert speeds == [("stay", 1.0, 0.0), ("left", 1.0, 1.0), ("right", 1.0, -1.0)]


def test_blind_scores_two_rho_r_within_its_interval() -> None:
    score = measure(BlindPolicy(), reference_contract(), agents=256, steps=400, discard=20)
    assert score.low < 36.0 < score.high
    assert score.contacts_per_100m == pytest.approx(100 * score.contacts / score.distance_m)
    assert score.high - score.low < 3.5


def test_random_is_worse_than_blind_and_looking_is_better() -> None:
    def rate(policy: BlindPolicy | RandomPolicy | OpenSidePolicy) -> float:
        score = measure(policy, reference_contract(), agents=128, steps=200, discard=20)
        return score.contacts_per_100m

    blind = rate(BlindPolicy())
    assert rate(RandomPolicy(0)) > 1.1 * blind
    assert rate(OpenSidePolicy()) < 0.7 * blind


def test_a_score_is_reproduced_to_the_bit() -> None:
    contract = reference_contract(RetinaSpec(rays=8))
    first, second = (
        measure(OpenSidePolicy(), contract, agents=40, steps=60, seeds=validation_seeds(30))
        for _ in range(2)
    )
    assert first == second


def test_discarded_steps_do_not_count_and_progress_is_told() -> None:
    told: list[tuple[int, int]] = []
    empty = World("empty", layers=())
    score = measure(
        BlindPolicy(),
        reference_contract(),
        agents=3,
        steps=20,
        discard=5,
        world=empty,
        progress=lambda done, total: told.append((done, total)),
    )
    assert score.distance_m == pytest.approx(3 * 20 * 0.1)
    assert (score.contacts, score.low, score.high, score.agents) == (0, 0.0, 0.0, 3)
    assert told == [(step, 25) for step in range(1, 26)]


def test_the_interval_is_as_wide_as_poisson_s() -> None:
    score = measure(BlindPolicy(), reference_contract(), agents=512, steps=150, discard=10)
    sigma = score.contacts_per_100m / math.sqrt(score.contacts)
    assert (score.high - score.low) / (2 * 1.96 * sigma) == pytest.approx(1.0, abs=0.25)
