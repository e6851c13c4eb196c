import math

import numpy as np
import pytest

from reflexarc_baselines.anchors.follow_the_gap import FollowTheGap, Gap, centre_rad, widest_gap
from reflexarc_baselines.baseline import Floats
from reflexarc_baselines.rays import bearings_rad
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.worlds.reference_contract import reference_retina

BEARINGS = bearings_rad(reference_retina())
NO_WIDTH = np.zeros((1, 16), np.float32)


def gap(left_deg: float, left_m: float, right_deg: float, right_m: float) -> Gap:
    left_rad, right_rad = math.radians(left_deg), math.radians(right_deg)
    return Gap(*(np.array([value]) for value in (left_rad, left_m, right_rad, right_m)))


def from_the_source(phi_1_deg: float, d1: float, phi_2_deg: float, d2: float) -> float:
    """The formula as it is printed: angles without sign, to the right of the axis positive."""
    phi_1, phi_2 = math.radians(phi_1_deg), math.radians(phi_2_deg)
    cosine = math.cos(phi_1 + phi_2)
    return math.acos((d1 + d2 * cosine) / math.sqrt(d1**2 + d2**2 + 2 * d1 * d2 * cosine)) - phi_1


def middle_point_rad(left_deg: float, d1: float, right_deg: float, d2: float) -> float:
    x = d1 * math.cos(math.radians(left_deg)) + d2 * math.cos(math.radians(right_deg))
    y = d1 * math.sin(math.radians(left_deg)) + d2 * math.sin(math.radians(right_deg))
    return math.atan2(y, x)


def seen(**rays_m: float) -> Floats:
    distances = np.full((1, 16), 5.0, np.float32)
    for ray, distance_m in rays_m.items():
        distances[0, int(ray[1:])] = distance_m
    return distances


@pytest.mark.parametrize(("phi_1", "d1", "phi_2", "d2"), [(30, 2, 40, 1), (10, 1, 60, 3)])
def test_with_borders_on_both_sides_the_centre_is_the_sources(
    phi_1: float, d1: float, phi_2: float, d2: float
) -> None:
    ours = centre_rad(gap(phi_1, d1, -phi_2, d2))[0]
    assert ours == pytest.approx(-from_the_source(phi_1, d1, phi_2, d2))


def test_with_borders_on_one_side_the_sources_formula_fails_and_ours_holds() -> None:
    """From +60° at 2 m to +20° at 1 m: the middle of the two points lies at 46.9°. The printed
    formula takes 60° and 20° for the two sides of the axis."""
    truth = middle_point_rad(60, 2, 20, 1)
    assert math.degrees(truth) == pytest.approx(46.9, abs=0.1)
    assert centre_rad(gap(60, 2, 20, 1))[0] == pytest.approx(truth)
    assert abs(-from_the_source(60, 2, 20, 1) - truth) > math.radians(10)


def test_the_nearer_border_pushes_the_centre_to_the_other_side() -> None:
    """Not the middle of the angles: at d₁ = 1, d₂ = 2 and ±45° atan(1/3) towards the farther."""
    assert centre_rad(gap(45, 1, -45, 2))[0] == pytest.approx(-math.atan(1 / 3))


def test_the_widest_gap_lies_between_the_borders_that_reach_farthest() -> None:
    """Rays 2, 3 and 13; between 3 and 13 it is widest."""
    found = widest_gap(seen(r2=1.0, r3=2.0, r13=1.5), BEARINGS, NO_WIDTH, 3.0)
    assert (found.left_rad[0], found.right_rad[0]) == (BEARINGS[3], BEARINGS[13])
    assert (found.left_m[0], found.right_m[0]) == (2.0, 1.5)


def test_an_obstacle_that_is_wider_hides_the_border_behind_it() -> None:
    """Ray 2 is widened by 40° and so reaches farther right than ray 3."""
    half_rad = NO_WIDTH.copy()
    half_rad[0, 2] = math.radians(40)
    found = widest_gap(seen(r2=1.0, r3=2.0, r13=1.5), BEARINGS, half_rad, 3.0)
    assert found.left_rad[0] == pytest.approx(BEARINGS[2] - math.radians(40))
    assert found.left_m[0] == 1.0


def test_the_ends_of_the_field_are_borders_as_far_away_as_it_sees() -> None:
    found = widest_gap(seen(r2=1.0), BEARINGS, NO_WIDTH, 3.0)
    assert (found.left_rad[0], found.left_m[0]) == (BEARINGS[2], 1.0)
    assert found.right_rad[0] == pytest.approx(-math.pi / 2)
    assert found.right_m[0] == 3.0


def test_the_nearer_the_nearest_the_more_the_gap_counts_against_the_goal() -> None:
    """φ = w φ_c / (w + 1) with w = α/d: for α = 2 and d = 1 two thirds."""
    policy = FollowTheGap(urgency_m=2.0, radius_m=0.0, seen_m=3.0)
    rays = seen(r0=1.0, r7=1.0)
    half_rad = np.full((1, 16), math.pi / 32, np.float32)
    centre = centre_rad(widest_gap(rays, BEARINGS, half_rad, 3.0))
    assert centre[0] < 0.0
    assert policy.heading_rad(rays)[0] == pytest.approx(centre[0] * 2 / 3, rel=1e-5)


def test_where_nothing_is_in_sight_or_nothing_is_open_it_stays() -> None:
    policy = FollowTheGap()
    assert policy.heading_rad(seen())[0] == pytest.approx(0.0, abs=1e-3)
    assert policy.heading_rad(np.full((1, 16), 0.1, np.float32))[0] == 0.0


def test_it_beats_random_motion() -> None:
    policy = FollowTheGap()
    assert measure(policy, policy.contract, agents=128, steps=200).contacts_per_100m < 0.4 * 48.0
