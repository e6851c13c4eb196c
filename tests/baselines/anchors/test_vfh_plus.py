import math

import numpy as np
import pytest

from reflexarc_baselines.anchors.vfh_plus import VfhPlus, openings
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.evaluation.reference_field import measure

RANGE_M = 5.0
SECTOR_RAD = math.radians(5.0)


def seeing(**rays_m: float) -> RetinaBatch:
    """A retina whose rays r0 to r15 meet something at the given distances."""
    retina = np.zeros((1, 1, 1, 16, 1), np.uint8)
    for ray, distance_m in rays_m.items():
        retina[0, 0, 0, int(ray[1:]), 0] = round(255 * (1.0 - distance_m / RANGE_M))
    return retina


def ranges(**rays_m: float) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    distances = np.full((1, 16), RANGE_M, np.float32)
    for ray, distance_m in rays_m.items():
        distances[0, int(ray[1:])] = distance_m
    return distances


def row(text: str) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.array([[mark == "#" for mark in text]])


def found(text: str, least: int) -> set[float]:
    places, counts = openings(row(text), least)
    return set(places[counts].tolist())


def test_what_is_met_counts_by_its_distance_in_all_sectors_of_its_enlargement() -> None:
    """Ray 7 at +5.625°, 1 m away, R = 0.1 m: asin(0.1) = 5.74°, so the sectors with middles from
    −0.11° to 11.36°, those at 2.5° and 7.5°; m = 1 + 0.5 (25 − 1) = 13."""
    density = VfhPlus(radius_m=0.1, falloff_per_m2=0.5).density(ranges(r7=1.0))[0]
    assert np.flatnonzero(density).tolist() == [16, 17]
    assert density[[16, 17]].tolist() == [13.0, 13.0]
    assert not VfhPlus().density(ranges(r7=RANGE_M)).any()


@pytest.mark.parametrize(("radius_m", "is_closed"), [(0.15, False), (0.3, True)])
def test_a_gap_narrower_than_the_body_is_closed(radius_m: float, is_closed: bool) -> None:
    """Rays 6 and 9 meet something 0.75 m away at ±16.875°, 2 · 0.75 sin 16.875° = 0.435 m apart.
    Each closes asin(R / 0.75 m): 11.5° of the 16.9° for R = 0.15 m, 23.6° for 0.3 m."""
    vfh = VfhPlus(radius_m=radius_m, low=1.0, rise=0.0)
    blocked = vfh.blocked(vfh.density(ranges(r6=0.75, r9=0.75)), row("." * 36))[0]
    between = np.abs(vfh.sectors_rad) < math.radians(16.875)
    assert blocked[between].all() == is_closed


def test_between_the_thresholds_a_sector_is_what_it_was() -> None:
    vfh = VfhPlus(low=10.0, rise=0.5)
    density = np.array([[9.9, 9.9, 12.0, 12.0, 15.1, 15.1]], np.float32)
    assert vfh.blocked(density, row(".#.#.#")).tolist() == row("...###").tolist()


def test_the_memory_keeps_the_blocked_sectors_between_two_calls() -> None:
    """At 1 m m = 25, at 2 m 22, at 4 m 10: thresholds 15 and 24 keep 2 m as it was before."""
    vfh = VfhPlus(low=15.0, rise=0.6)
    start = np.zeros((1, 38), np.float32)
    _, _, fresh = vfh.decide(seeing(r7=2.0), start)
    _, _, near = vfh.decide(seeing(r7=1.0), start)
    _, _, after = vfh.decide(seeing(r7=2.0), near)
    _, _, away = vfh.decide(seeing(r7=4.0), after)
    assert not fresh[0, :36].any()
    assert near[0, :36].any()
    assert after[0, :36].any()
    assert not away[0, :36].any()
    assert not start.any(), "what was given is left as it was"


def test_a_narrow_opening_has_its_middle_a_wide_one_both_sides_and_what_is_ahead() -> None:
    """Of ten sectors 4.5 is ahead. Half of 3 sectors from its ends a wide opening has its sides."""
    assert found("##..######", least=3) == {2.5}
    assert found("....######", least=3) == {1.0, 2.0}
    assert found("##......##", least=3) == {3.0, 6.0, 4.5}
    assert found("..........", least=3) == {1.0, 8.0, 4.5}
    assert found("##########", least=3) == set()


def test_the_goal_weighs_more_than_the_last_motion_and_the_choice_before_together() -> None:
    """μ₁ > μ₂ + μ₃: nothing in sight, it goes ahead even after a choice and a motion aside."""
    vfh = VfhPlus()
    goal, motion, choice = vfh.weights
    assert goal > motion + choice
    memory = np.array([[0.0] * 36 + [math.pi / 4, 1.0]], np.float32)
    assert vfh.decide(seeing(), memory)[1].tolist() == [0]


def test_of_two_equal_openings_it_takes_the_side_that_it_chose_before() -> None:
    vfh = VfhPlus(low=1.0, rise=0.0)
    wall = seeing(r7=1.0, r8=1.0)
    for side, action in ((0.3, 1), (-0.3, 2)):
        memory = np.array([[0.0] * 36 + [0.0, side]], np.float32)
        assert vfh.decide(wall, memory)[1].tolist() == [action]


def test_the_cost_of_a_candidate_by_hand() -> None:
    """5 · 0.2 + 2 · |0.2 − 0.785| + 3 · |0.2 + 0.1| = 1 + 1.17 + 0.9."""
    vfh = VfhPlus(weights=(5.0, 2.0, 3.0))
    at = np.array([[0.2]], np.float32)
    motion, choice = np.array([0.785], np.float32), np.array([-0.1], np.float32)
    assert vfh.cost(at, motion, choice)[0, 0] == pytest.approx(3.07, rel=1e-6)


def test_where_all_is_blocked_it_heads_for_the_least_dense_sector() -> None:
    density = np.full((1, 36), 30.0, np.float32)
    density[0, 30] = 29.0
    zero = np.zeros(1, np.float32)
    chosen = VfhPlus().choice_rad(row("#" * 36), density, zero, zero)
    assert chosen[0] == pytest.approx((17.5 - 30) * SECTOR_RAD, rel=1e-6)


def test_it_beats_random_motion() -> None:
    vfh = VfhPlus()
    assert measure(vfh, vfh.contract, agents=128, steps=200).contacts_per_100m < 0.4 * 48.0
