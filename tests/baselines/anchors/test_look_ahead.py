import math

import numpy as np
import pytest

from reflexarc_baselines.anchors.look_ahead import LookAhead
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_sim_bridge.evaluation.reference_field import measure

STAY, LEFT, RIGHT = range(3)


def free_s(policy: LookAhead, row: int, *points: tuple[float, float]) -> float:
    x_m, y_m = np.array([points], np.float32).transpose(2, 0, 1)
    return float(policy.free_s(x_m, y_m, row)[0])


def only_hold(hold_s: float) -> LookAhead:
    return LookAhead(half_width_m=0.2, holds=1, longest_hold_s=hold_s, horizon_s=4.0)


def by_small_steps(policy: LookAhead, row: int, points: list[tuple[float, float]]) -> float:
    """The slow exact version: drive a narrow bar, 0.4 m wide, in steps of a millisecond."""
    lateral_mps = (0.0, 1.0, -1.0)[row]
    for step in range(4000):
        t = step * 1e-3
        aside_s = min(t, policy.longest_hold_s)
        x, y = t, lateral_mps * aside_s
        heading = math.atan2(lateral_mps, 1.0) if t < policy.longest_hold_s else 0.0
        for px, py in points:
            along = (px - x) * math.cos(heading) + (py - y) * math.sin(heading)
            aside = (py - y) * math.cos(heading) - (px - x) * math.sin(heading)
            if abs(aside) < 0.2 and -2e-3 < along <= 0.0:
                return t
    return 4.0


def test_straight_ahead_it_is_free_until_the_point_in_its_strip() -> None:
    """At 1 m/s the point 1.5 m ahead is met after 1.5 s; one 0.25 m aside is passed."""
    assert free_s(only_hold(0.5), STAY, (1.5, 0.1), (1.0, 0.25)) == pytest.approx(1.5)


def test_stepping_aside_it_is_free_along_the_diagonal() -> None:
    """(0.6, 0.6) is met after 0.6 s; with a hold of 0.5 s the body goes ahead at y = 0.5 m before
    it, and meets it, 0.1 m aside, after 0.6 s as well; (0.6, 0.8) is passed then."""
    assert free_s(only_hold(1.0), LEFT, (0.6, 0.6)) == pytest.approx(0.6)
    assert free_s(only_hold(0.5), LEFT, (0.6, 0.6)) == pytest.approx(0.6)
    assert free_s(only_hold(0.5), LEFT, (0.6, 0.8)) == pytest.approx(4.0)
    assert free_s(only_hold(0.5), RIGHT, (0.6, 0.6)) == pytest.approx(4.0)


@pytest.mark.parametrize("row", [STAY, LEFT, RIGHT])
@pytest.mark.parametrize("hold_s", [0.3, 1.0])
def test_the_time_is_that_of_a_drive_in_small_steps(row: int, hold_s: float) -> None:
    generator = np.random.default_rng(row)
    for _ in range(6):
        points = [(float(x), float(y)) for x, y in generator.uniform((0.4, -1), (3, 1), (4, 2))]
        slow = by_small_steps(only_hold(hold_s), row, points)
        assert free_s(only_hold(hold_s), row, *points) == pytest.approx(slow, abs=5e-3)


def test_of_the_hold_times_the_best_counts() -> None:
    """A wall of points 1 m ahead with a door at y = 0.5: only half a second to the left leads
    through it; half of the longest hold, 1 s, is tried as well."""
    wall = [(1.0, y / 10) for y in range(-20, 21) if not 2 < y < 8]
    assert free_s(only_hold(1.0), LEFT, *wall) < 1.01
    both = LookAhead(half_width_m=0.15, holds=2, longest_hold_s=1.0, horizon_s=4.0)
    assert free_s(both, LEFT, *wall) == pytest.approx(4.0)


def test_what_a_ray_does_not_meet_is_free() -> None:
    nothing: RetinaBatch = np.zeros((1, 1, 1, 16, 1), np.uint8)
    policy = LookAhead(half_width_m=1.0, horizon_s=8.0)
    q_values, actions = policy.decide(nothing)
    assert q_values[0].tolist() == pytest.approx([8.0 + policy.preference_s, 8.0, 8.0])
    assert actions.tolist() == [STAY]


def test_it_beats_random_motion() -> None:
    policy = LookAhead()
    assert measure(policy, policy.contract, agents=128, steps=200).contacts_per_100m < 0.4 * 48.0
