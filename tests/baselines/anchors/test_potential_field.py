import numpy as np
import pytest

from reflexarc_baselines.anchors.potential_field import PotentialField
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.evaluation.reference_field import measure


def lit(**rays: int) -> RetinaBatch:
    retina = np.zeros((1, 1, 1, 16, 1), np.uint8)
    for ray, value in rays.items():
        retina[0, 0, 0, int(ray[1:]), 0] = value
    return retina


def test_the_force_is_the_slope_of_the_potential() -> None:
    """Of U = ½ (1/d − 1/d0)², by differences."""
    reach_m, step_m = 2.0, 1e-4

    def potential(distance_m: float) -> float:
        return 0.5 * (1.0 / distance_m - 1.0 / reach_m) ** 2

    for distance_m in (0.3, 0.7, 1.5):
        slope = (potential(distance_m + step_m) - potential(distance_m - step_m)) / (2 * step_m)
        force = PotentialField(reach_m=reach_m).force(np.array([[distance_m]], np.float32))
        assert force[0, 0] == pytest.approx(-slope, rel=1e-5)


def test_beyond_its_reach_nothing_pushes() -> None:
    force = PotentialField(reach_m=2.0).force(np.array([[2.0, 2.1, 5.0]], np.float32))
    assert force.tolist() == [[0.0, 0.0, 0.0]]


def test_one_ray_pushes_aside_by_the_sine_of_its_bearing() -> None:
    """Ray 5 at 28.125°; value 204 is 1 m: (1 − ½) / 1² · sin 28.125° = 0.2357 to the right."""
    q_values, actions = PotentialField(reach_m=2.0, pull=0.1).decide(lit(r5=204))
    assert q_values[0].tolist() == pytest.approx([0.1, -0.2357, 0.2357], abs=1e-4)
    assert actions.tolist() == [2]


def test_a_push_weaker_than_the_pull_ahead_changes_nothing() -> None:
    assert PotentialField(reach_m=2.0, pull=0.24).decide(lit(r5=204))[1].tolist() == [0]
    assert PotentialField().decide(lit(r5=204, r10=204))[1].tolist() == [0]


def test_a_thing_at_no_distance_pushes_by_a_finite_force() -> None:
    q_values, actions = PotentialField().decide(lit(r5=255))
    assert np.isfinite(q_values).all()
    assert actions.tolist() == [2]


def test_it_beats_random_motion() -> None:
    policy = PotentialField()
    assert measure(policy, policy.contract, agents=128, steps=200).contacts_per_100m < 0.4 * 48.0
