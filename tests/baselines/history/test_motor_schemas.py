import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_baselines.history.motor_schemas import (
    HUGE,
    MotorSchemasLargest,
    MotorSchemasSum,
)
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import RandomPolicy
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from support.ranges_seen import BEARINGS_RAD, far_except, unremembered

BOTH = [MotorSchemasSum, MotorSchemasLargest]
Kind = type[MotorSchemasSum] | type[MotorSchemasLargest]


def ranges(*distances_m: float) -> npt.NDArray[np.float32]:
    """These distances on the first rays, nothing on the others."""
    padded = [*distances_m, *[5.0] * (16 - len(distances_m))]
    return np.array([padded], np.float32)


@pytest.mark.parametrize("kind", BOTH)
@pytest.mark.parametrize(
    ("distance_m", "magnitude"),
    [(1.6, 0.0), (1.5, 0.0), (0.8, 0.5), (0.1001, 1.0), (0.1, HUGE), (0.0, HUGE)],
)
def test_avoid_grows_from_0_at_its_border_to_1_at_the_safe_distance_and_is_huge_within(
    kind: Kind, distance_m: float, magnitude: float
) -> None:
    avoid = kind(influence_m=1.5, safe_m=0.1).avoid(ranges(distance_m))
    assert avoid.lengths[0] == pytest.approx(magnitude, abs=1e-4, rel=1e-5)


def test_a_second_equal_thing_doubles_the_sum_and_leaves_the_largest() -> None:
    """Two rays at ±5.6°, so nearly in the same place: the sum is 2 cos 5.6° times as long."""
    one, two = np.full((1, 16), 5.0, np.float32), np.full((1, 16), 5.0, np.float32)
    one[0, 7] = two[0, 7] = two[0, 8] = 0.8
    narrow = 2.0 * math.cos(BEARINGS_RAD[7])
    summed, largest = MotorSchemasSum(influence_m=1.5), MotorSchemasLargest(influence_m=1.5)
    assert summed.avoid(two).lengths[0] == pytest.approx(narrow * summed.avoid(one).lengths[0])
    assert largest.avoid(two).lengths[0] == pytest.approx(largest.avoid(one).lengths[0])


def test_the_largest_keeps_the_direction_of_the_sum() -> None:
    uneven = ranges(0.3, 0.9, 1.2, 0.5)
    summed = MotorSchemasSum(influence_m=1.5).avoid(uneven)
    largest = MotorSchemasLargest(influence_m=1.5).avoid(uneven)
    assert largest.headings_rad[0] == pytest.approx(summed.headings_rad[0], abs=1e-6)
    assert largest.lengths[0] == pytest.approx((1.5 - 0.3) / 1.4)


@pytest.mark.parametrize("kind", BOTH)
def test_nothing_within_reach_is_no_avoid_at_all(kind: Kind) -> None:
    """Not even with a border beyond the eye's range, where the sum of pushes has no direction."""
    assert kind(influence_m=9.0).avoid(ranges()).lengths[0] == 0.0


@pytest.mark.parametrize(("noise_rad", "side"), [(0.6, 1), (-0.6, -1)])
def test_swirl_passes_a_thing_on_the_side_of_the_noise(noise_rad: float, side: int) -> None:
    """A thing ahead and a little left, half-way in (1.05 of 0.1 to 2 m): ½, at a right angle."""
    ranges_m = np.full((1, 16), 5.0, np.float32)
    ranges_m[0, 7] = 1.05
    swirl = MotorSchemasSum(swirl_influence_m=2.0).swirl(
        ranges_m, np.array([noise_rad], np.float32)
    )
    assert swirl.lengths[0] == pytest.approx(0.5)
    assert swirl.headings_rad[0] == pytest.approx(BEARINGS_RAD[7] + side * math.pi / 2, abs=1e-6)


def test_swirl_leaves_alone_what_lies_behind_the_noise() -> None:
    behind = np.array([math.pi - 0.1], np.float32)
    ranges_m = np.full((1, 16), 5.0, np.float32)
    ranges_m[0, 8] = 1.0
    assert MotorSchemasSum().swirl(ranges_m, behind).lengths[0] == 0.0


@pytest.mark.parametrize(("period_s", "decisions"), [(0.1, 50), (0.02, 250)])
def test_noise_points_everywhere_and_is_held_five_seconds(period_s: float, decisions: int) -> None:
    """In empty space T is the direction of (1, 0) + 0.5 û, which changes with û alone."""
    schemas = MotorSchemasSum(noise_gain=0.5, dead_band_rad=0.0, period_s=period_s)
    memory, found = unremembered(schemas.contract), []
    for _ in range(20 * decisions):
        q_values, _, memory = schemas.decide(far_except(), memory)
        found.append(float(q_values[0, 1]))
    changes = [k for k, (before, after) in enumerate(pairwise(found), 1) if before != after]
    assert changes == list(range(decisions, 20 * decisions, decisions))
    # Within ±1 rad it would be 0.32 at most; the greatest of all, at 120°, is asin ½ = 0.52.
    assert min(found) < -0.4
    assert max(found) > 0.4
    assert max(map(abs, found)) <= math.asin(0.5) + 1e-6


def test_without_noise_and_things_it_goes_ahead() -> None:
    schemas = MotorSchemasSum(noise_gain=0.0)
    _, winners, _ = schemas.decide(far_except(), unremembered(schemas.contract))
    assert winners.tolist() == [0]


@pytest.mark.parametrize("kind", BOTH)
def test_it_beats_random_motion_on_the_reference_field(kind: Kind) -> None:
    schemas = kind()
    random = measure(RandomPolicy(1), replace(schemas).drives_by, agents=128, steps=200)
    assert measure(schemas, schemas.contract, agents=128, steps=200).high < random.low


@pytest.mark.parametrize("ray", range(8))
def test_pushes_that_cancel_out_have_no_direction_however_they_are_rounded(ray: int) -> None:
    """Sixteen rays all around: ray i and ray i + 8 look in opposite directions."""
    around = replace(reference_contract().retina, fov_rad=2.0 * np.pi)
    schemas = MotorSchemasLargest(drives_by=replace(reference_contract(), retina=around))
    ranges_m = np.full((1, 16), 5.0, np.float32)
    ranges_m[0, [ray, ray + 8]] = 0.8
    assert schemas.avoid(ranges_m).lengths == pytest.approx(0.0, abs=1e-6)
