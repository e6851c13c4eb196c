import math

import numpy as np
import pytest

from reflexarc_baselines.anchors.bubble_gap import BubbleGap, longest_run
from reflexarc_baselines.baseline import Floats
from reflexarc_sim_bridge.evaluation.reference_field import measure


def seen(**rays_m: float) -> Floats:
    distances = np.full((1, 16), 5.0, np.float32)
    for ray, distance_m in rays_m.items():
        distances[0, int(ray[1:])] = distance_m
    return distances


@pytest.mark.parametrize(
    ("rays", "middle", "length"),
    [("..###.", 3.0, 3.0), ("##..##", 0.5, 2.0), (".....#", 5.0, 1.0), ("......", 0.5, 0.0)],
)
def test_the_longest_run_and_of_equals_the_first(rays: str, middle: float, length: float) -> None:
    got = longest_run(np.array([[ray == "#" for ray in rays]]))
    assert got[1][0] == length
    assert length == 0.0 or got[0][0] == middle


def test_it_heads_for_the_middle_of_the_longest_run() -> None:
    """Ray 7 is near and closed; rays 8 to 15 are the longer run: its middle is 11.5, at −45°."""
    policy = BubbleGap(bubble_m=0.0, threshold_m=1.0)
    assert policy.heading_rad(seen(r7=0.9))[0] == pytest.approx(math.radians(-45), rel=1e-6)


def test_the_bubble_closes_the_rays_that_end_near_the_nearest_point() -> None:
    """Rays 8 and 9 at 2 m end 2 · 2 sin 5.625° = 0.392 m apart. A bubble of 0.4 m around the
    nearer one, ray 8, closes 9 and 7 too, where 2 m are measured; then 10 to 15 and 0 to 6 are
    left, 7 rays whose middle is 3, at 50.6°."""
    rays = seen(r7=2.0, r8=1.99, r9=2.0)
    small, large = (
        BubbleGap(bubble_m=0.38, threshold_m=1.0),
        BubbleGap(bubble_m=0.4, threshold_m=1.0),
    )
    assert large.heading_rad(rays)[0] == pytest.approx(math.radians(50.625), rel=1e-5)
    assert small.heading_rad(rays)[0] == pytest.approx(math.radians(45.0), rel=1e-5)


def test_where_no_ray_is_free_it_stays() -> None:
    assert BubbleGap().heading_rad(np.full((1, 16), 0.1, np.float32))[0] == 0.0


def test_it_beats_random_motion() -> None:
    policy = BubbleGap()
    assert measure(policy, policy.contract, agents=128, steps=200).contacts_per_100m < 0.4 * 48.0
