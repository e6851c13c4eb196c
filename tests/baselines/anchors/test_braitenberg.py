import numpy as np
import pytest

from reflexarc_baselines.anchors.braitenberg import Braitenberg2a, Braitenberg2b
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy


def lit(*rays: int) -> RetinaBatch:
    retina = np.zeros((1, 1, 1, 16, 1), np.uint8)
    retina[0, 0, 0, list(rays), 0] = 255
    return retina


@pytest.mark.parametrize(("ray", "winner"), [(6, 2), (9, 1)])
def test_2a_turns_away_from_the_light(ray: int, winner: int) -> None:
    assert Braitenberg2a().decide(lit(ray))[1].tolist() == [winner]


def test_one_ray_pulls_by_the_cosine_of_its_bearing() -> None:
    """Ray 2 of 16 over π stands at 90° − 2.5 · 11.25° = 61.875°; each side has 8 rays."""
    q_values, _ = Braitenberg2a(power=1.0, dead_band=0.0).decide(lit(2))
    assert q_values[0, 1] == pytest.approx(-np.cos(np.radians(61.875)) / 8, rel=1e-6)


def test_nothing_in_sight_and_equal_sides_are_no_reason_to_turn() -> None:
    assert Braitenberg2a().decide(lit())[1].tolist() == [0]
    assert Braitenberg2a().decide(lit(3, 12))[1].tolist() == [0]


def test_2a_does_far_better_than_blind_and_2b_far_worse() -> None:
    def rate(policy: Braitenberg2a | BlindPolicy) -> float:
        score = measure(policy, Braitenberg2a().contract, agents=128, steps=200)
        return score.contacts_per_100m

    blind = rate(BlindPolicy())
    assert rate(Braitenberg2a()) < 0.3 * blind
    assert rate(Braitenberg2b()) > 2.0 * blind
