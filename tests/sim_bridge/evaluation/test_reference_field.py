import math
from typing import Any

import numpy as np
import pytest

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import UsageError
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


def said_of(policy: object, **wishes: Any) -> str:
    contract = wishes.pop("contract", reference_contract())
    few = {"agents": 4, "steps": 3, "discard": 0} | wishes
    with pytest.raises(UsageError) as error:
        measure(policy, contract, **few)  # type: ignore[arg-type]  # what somebody may give
    assert "\n" not in str(error.value)
    return str(error.value)


class Deciding:
    """Decides what it was told to, whatever it sees."""

    def __init__(self, winners: object) -> None:
        self._winners = winners

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, object]:
        if isinstance(self._winners, Exception):
            raise self._winners
        return np.zeros((len(retinas), 3), np.float32), self._winners


@pytest.mark.parametrize("policy", [None, "reflex", object(), 3.5, lambda retinas: retinas])
def test_what_is_no_policy_is_refused(policy: object) -> None:
    assert said_of(policy).startswith("policy: expected an object with decide, got ")


@pytest.mark.parametrize(
    ("wishes", "words"),
    [
        ({"steps": 0}, "steps: expected a whole number of 1 or more, got 0"),
        ({"agents": 0}, "agents: expected a whole number of 1 or more, got 0"),
        ({"agents": -3}, "agents: expected"),
        ({"steps": math.nan}, "steps: expected"),
        ({"steps": 2.5}, "steps: expected"),
        ({"discard": -1}, "discard: expected a whole number of 0 or more, got -1"),
        ({"seeds": np.empty(0, np.uint64)}, "seeds: expected at least one, got none"),
        ({"contract": None}, "contract: expected a PolicyContract, got NoneType"),
    ],
)
def test_what_says_nothing_cannot_be_measured(wishes: dict[str, Any], words: str) -> None:
    assert said_of(BlindPolicy(), **wishes).startswith(words)


@pytest.mark.parametrize(
    ("winners", "words"),
    [
        (np.zeros(3, np.int64), "got int64 of shape (3,)"),
        (np.zeros((4, 1), np.int64), "got int64 of shape (4, 1)"),
        (np.full(4, np.nan), "got float64 of shape (4,)"),
        (np.array([0, 0, 0, 3]), "from 0 to 2, got 3"),
        (np.array([0, -1, 0, 0]), "from 0 to 2, got -1"),
        (ValueError("a\nb"), "the policy raised ValueError: a"),
    ],
)
def test_decisions_that_are_none_are_refused(winners: object, words: str) -> None:
    assert words in said_of(Deciding(winners))
