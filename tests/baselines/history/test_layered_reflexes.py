import math

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_baselines.history.layered_reflexes import (
    LayeredPerimeter,
    LayeredWander,
    Primitive,
)
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import RandomPolicy
from support.ranges_seen import BEARINGS_RAD, seen

WALL_M = 30.0
Kind = type[LayeredWander] | type[LayeredPerimeter]
ALL = tuple(Primitive)
SOME = np.random.default_rng(2).uniform(0.2, 5.0, (20, 16)).astype(np.float32)


@pytest.mark.parametrize("muted", ALL)
def test_muting_one_primitive_removes_its_term_only(muted: Primitive) -> None:
    everything = LayeredWander(primitives=ALL)
    others = LayeredWander(primitives=tuple(name for name in ALL if name is not muted))
    whole, rest, term = everything.wish(SOME), others.wish(SOME), everything.term(muted, SOME)
    np.testing.assert_allclose(whole.ahead, rest.ahead + term.ahead, rtol=1e-5, atol=1e-6)
    np.testing.assert_allclose(whole.left, rest.left + term.left, rtol=1e-5, atol=1e-6)
    assert (term.lengths > 0.0).all()


def test_behaviours_are_sets() -> None:
    avoids = {Primitive.PASSIVE_AVOID, Primitive.ACTIVE_AVOID}
    assert set(LayeredWander().primitives) == avoids | {Primitive.FORWARD}
    assert set(LayeredPerimeter().primitives) == {Primitive.PASSIVE_AVOID, Primitive.PERIMETER}


def one_near(ray: int, distance_m: float) -> npt.NDArray[np.float32]:
    ranges_m = np.full((1, 16), 5.0, np.float32)
    ranges_m[0, ray] = distance_m
    return ranges_m


def test_one_thing_pushes_passively_with_the_inverse_of_its_distance() -> None:
    term = LayeredWander().term(Primitive.PASSIVE_AVOID, one_near(4, 2.0))
    push = -LayeredWander().passive_gain * math.pi / 16 / 2.0
    expected = [push * math.cos(BEARINGS_RAD[4]), push * math.sin(BEARINGS_RAD[4])]
    assert [term.ahead[0], term.left[0]] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize(("ray", "left"), [(6, -0.5), (9, 0.5), (2, 0.0), (13, 0.0)])
def test_only_what_is_ahead_pushes_actively_and_straight_aside(ray: int, left: float) -> None:
    term = LayeredWander(active_gain=1.0).term(Primitive.ACTIVE_AVOID, one_near(ray, 2.0))
    assert (term.ahead[0], term.left[0]) == pytest.approx((0.0, left))


def test_open_space_pulls_to_the_farthest_ray() -> None:
    ranges_m = np.full((1, 16), 1.0, np.float32)
    ranges_m[0, 3] = 2.0
    term = LayeredWander(open_gain=1.0).term(Primitive.OPEN_SPACE, ranges_m)
    assert term.headings_rad[0] == pytest.approx(BEARINGS_RAD[3], rel=1e-6)
    assert LayeredWander().term(Primitive.OPEN_SPACE, ranges_m * 0 + 5).headings_rad[0] > 0.0


@pytest.mark.parametrize(("ray", "degrees"), [(0, 39.375), (15, -39.375), (5, 0.0)])
def test_perimeter_pulls_along_what_is_near_and_to_it(ray: int, degrees: float) -> None:
    """84.375° less 45°; what is nearer to ahead than 45° is gone to straight on."""
    term = LayeredPerimeter(keeps_m=2.0).term(Primitive.PERIMETER, one_near(ray, 1.0))
    assert math.degrees(term.headings_rad[0]) == pytest.approx(degrees, abs=1e-4)
    assert term.lengths[0] == pytest.approx(math.pi / 8 * math.sqrt(2))


def test_where_nothing_is_near_nothing_pulls_along() -> None:
    term = LayeredPerimeter().term(Primitive.PERIMETER, np.full((1, 16), 5.0, np.float32))
    assert term.lengths[0] == 0.0


def beside_wall(x_m: float, gap_m: float) -> npt.NDArray[np.float64]:
    """Distances to a wall on the left, parallel to the way, from x = 0 to 30 m."""
    with np.errstate(divide="ignore"):
        ranges_m = np.where(BEARINGS_RAD > 0.0, gap_m / np.sin(BEARINGS_RAD), np.inf)
    meets = x_m + ranges_m * np.cos(BEARINGS_RAD) <= WALL_M
    return np.where(meets, ranges_m, np.inf)


def test_a_long_wall_pushes_aside_with_a_quarter_of_pi_over_its_distance() -> None:
    """∫ sin²φ dφ over a quarter turn; rays that reach farther than 5 m miss 1 % of it."""
    ranges_m = np.minimum(beside_wall(5.0, 0.8), 5.0).astype(np.float32)[np.newaxis]
    push = LayeredWander(passive_gain=1.0).term(Primitive.PASSIVE_AVOID, ranges_m)
    assert push.left[0] == pytest.approx(-math.pi / 4.0 / 0.8, rel=0.01)


def gaps_along_the_wall(policy: LayeredWander | LayeredPerimeter, gap_m: float) -> list[float]:
    """A body of 1 m/s ahead and 1 m/s aside, 10 decisions a second, for 24 m."""
    gaps = []
    for decision in range(240):
        _, winners = policy.decide(seen(beside_wall(0.1 * decision, gap_m)))
        gap_m += 0.1 * (0.0, -1.0, 1.0)[winners[0]]
        gaps.append(gap_m)
    return gaps


@pytest.mark.parametrize("start_m", [0.5, 1.0, 2.0])
def test_perimeter_holds_its_distance_beside_a_wall(start_m: float) -> None:
    """Within 20 % of D = 1 m, from where it has had time to come: 2 m on."""
    perimeter = LayeredPerimeter(keeps_m=1.0, passive_gain=1.0, dead_band_rad=0.1)
    assert all(abs(gap - 1.0) <= 0.2 for gap in gaps_along_the_wall(perimeter, start_m)[20:])


def test_wander_does_not() -> None:
    gaps = gaps_along_the_wall(LayeredWander(), 1.0)
    assert gaps[-1] > 1.4


@pytest.mark.parametrize("kind", [LayeredWander, LayeredPerimeter])
def test_it_beats_random_motion_on_the_reference_field(kind: Kind) -> None:
    reflexes = kind()
    random = measure(RandomPolicy(1), reflexes.contract, agents=128, steps=200)
    assert measure(reflexes, reflexes.contract, agents=128, steps=200).high < random.low
