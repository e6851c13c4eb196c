import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_baselines.history.rob_nav import LEFT, LEVEL, SIDE, RobNav
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.sensing.retina import retina_from_scan
from reflexarc_runtime.sensing.scan import Scan
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import RandomPolicy
from support.ranges_seen import BEARINGS_RAD, RANGE_M, far_except, seen, unremembered

ROB = RobNav(half_width_m=0.45)
"""t = 0.45 s; the front is 0.9 m long; limits 0.9 s, 1.8 s, 1.8 to 3.6 s."""
FREE = far_except()
BLOCKED = far_except(ray7=0.5, ray3=2.0)
"""Something ahead; the right is the clearer side."""


def levels(script: list[RetinaBatch], rob: RobNav = ROB) -> tuple[list[int], list[int]]:
    """Levels and sides, decision by decision."""
    memory, states = unremembered(rob.contract), []
    for retina in script:
        _, winners, memory = rob.decide(retina, memory)
        states.append((int(memory[0, LEVEL]), int(memory[0, SIDE])))
        assert winners[0] == {0: 0, 1: 1, -1: 2}[states[-1][1]]
    return [level for level, _ in states], [side for _, side in states]


def test_each_level_has_its_time_and_then_calls_the_next() -> None:
    """At 10 Hz: 9 decisions to the clearer side, 18 to the other, then detours by chance."""
    found, sides = levels([FREE] * 3 + [BLOCKED] * 60)
    assert found == [0] * 3 + [1] * 9 + [2] * 18 + [3] * 33
    assert sides[3:30] == [-1] * 9 + [1] * 18
    assert set(sides[30:]) <= {-1, 1}


@pytest.mark.parametrize("blocked", [1, 5, 9, 10, 27, 28, 70])
def test_success_leads_back_to_the_first_level_from_every_other(blocked: int) -> None:
    found, sides = levels([BLOCKED] * blocked + [FREE] * 2 + [BLOCKED])
    assert found[blocked:] == [0, 0, 1]
    assert sides[blocked:] == [0, 0, -1]


def test_no_level_is_ever_skipped() -> None:
    """On any front signal the next level is the same, the next higher one, or 0."""
    front = np.random.default_rng(5).random(3000) < 0.97
    found, _ = levels([BLOCKED if is_blocked else FREE for is_blocked in front])
    assert {3, 2, 1, 0} == set(found)
    assert all(later in (0, earlier, earlier + 1) for earlier, later in pairwise(found))


def test_detours_last_between_four_and_eight_times_the_way_aside() -> None:
    """18 to 36 decisions, and both sides occur; agents that see different things differ."""
    agents = 400
    retinas = np.repeat(BLOCKED, agents, axis=0)
    retinas[:, 0, 0, 15, 0] = np.arange(agents) % 100
    retinas[:, 0, 0, 0, 0] = np.arange(agents) // 100
    memory = unremembered(ROB.contract, agents)
    for _ in range(9 + 18 + 1):
        memory = ROB.decide(retinas, memory)[2]
    lengths = memory[:, LEFT] + 1.0
    assert (lengths.min(), lengths.max()) == (18.0, 36.0)
    assert 0.4 < (memory[:, SIDE] > 0.0).mean() < 0.6


def test_limits_are_in_seconds_at_any_rate() -> None:
    """At 50 Hz: 45 and 90 decisions."""
    found, _ = levels([BLOCKED] * 136, replace(ROB, period_s=0.02))
    assert found == [1] * 45 + [2] * 90 + [3]


@pytest.mark.parametrize(
    ("ray", "range_m", "is_clear"),
    [
        (7, 0.88, False),
        (7, 0.94, True),  # farther than 0.9 m ahead
        (4, 0.7, False),  # 39.4°: 0.44 m aside
        (4, 0.74, True),  # 0.47 m aside
        (0, 0.40, False),  # abeam, and still in front by 4 cm
    ],
)
def test_the_front_is_a_strip_as_wide_as_an_obstacle(
    ray: int, range_m: float, is_clear: bool
) -> None:
    ranges_m = np.full((1, 16), RANGE_M, np.float32)
    ranges_m[0, ray] = range_m
    assert ROB.is_clear(ranges_m).tolist() == [is_clear]


def test_a_ray_that_meets_nothing_blocks_no_front_however_long() -> None:
    assert RobNav(half_width_m=4.0).is_clear(np.full((1, 16), RANGE_M, np.float32)).all()


def test_a_retina_and_a_scan_move_it_to_the_same_bits() -> None:
    """A drive past a disc of 0.5 m, 3 m ahead: a retina by hand, and one made from a scan."""
    by_retina = by_scan = unremembered(ROB.contract)
    for k in range(60):
        ranges_m = to_disc(3.0 - 0.1 * k, 0.1)
        scan = Scan(BEARINGS_RAD[-1], BEARINGS_RAD[0], ranges_m[::-1].copy())
        scanned = retina_from_scan(scan, ROB.drives_by.retina)[np.newaxis, np.newaxis]
        q_seen, _, by_retina = ROB.decide(seen(ranges_m), by_retina)
        q_scanned, _, by_scan = ROB.decide(scanned, by_scan)
        assert q_seen.tobytes() == q_scanned.tobytes()
        assert by_retina.tobytes() == by_scan.tobytes()


def to_disc(x_m: float, y_m: float, radius_m: float = 0.5) -> npt.NDArray[np.float64]:
    """Distances of the rays to a disc; +inf past it."""
    along = x_m * np.cos(BEARINGS_RAD) + y_m * np.sin(BEARINGS_RAD)
    missed = x_m**2 + y_m**2 - along**2
    reach = along - np.sqrt(np.maximum(radius_m**2 - missed, 0.0))
    return np.where((missed < radius_m**2) & (reach > 0.0), reach, np.inf)


def test_a_body_that_turns_has_the_time_that_an_arc_needs() -> None:
    """An arc of radius v/ω leaves its tangent by v ω t²/2 = R: t = 0.6708 s at 2 rad/s."""
    turning = (Action("stay", 1.0, 0.0), Action("left", 1.0, 0.0, 2.0), Action("right", 1, 0, -2))
    rob = replace(ROB, drives_by=replace(ROB.drives_by, actions=turning))
    assert rob.aside_s == pytest.approx(math.sqrt(0.45))
    assert levels([BLOCKED] * 2, rob)[0] == [1, 1]


def test_it_beats_random_motion_on_the_reference_field() -> None:
    rob = RobNav()
    random = measure(RandomPolicy(1), rob.drives_by, agents=128, steps=200)
    assert measure(rob, rob.contract, agents=128, steps=200).high < random.low
