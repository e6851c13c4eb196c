import math
from dataclasses import replace

import numpy as np
import pytest

from reflexarc_baselines.baseline import Baseline, Remembering
from reflexarc_baselines.history.subsumption import (
    Module,
    Subsumption,
    Subsumption0,
    Subsumption1,
)
from reflexarc_baselines.registry import baseline_named
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.motion import Action
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import RandomPolicy
from support.ranges_seen import BEARINGS_RAD, assorted, far_except, unremembered

LEFT = 1
LEVEL_0 = Subsumption0(gain=2.0, dead_band_rad=0.0, threshold=0.1)
LEVEL_1 = Subsumption1(gain=2.0, dead_band_rad=0.0, threshold=0.1, wander_s=10.0, widest_rad=1.0)
EMPTY = far_except()
BESIDE = far_except(ray10=1.0)
ANGLE_RAD = math.pi / 16


def headings(policies: list[Subsumption1] | list[Subsumption], retina: RetinaBatch) -> list[float]:
    """T, decision by decision, each by its own policy, with one memory."""
    memory, found = unremembered(policies[0].contract), []
    for policy in policies:
        q_values, _, memory = policy.decide(retina, memory)
        found.append(float(q_values[0, LEFT]))
    return found


def test_one_thing_pushes_with_the_inverse_square_of_its_distance() -> None:
    """Ray 10 of 16 stands at −28.125°. At 2 m (153/255 of 5 m: seen as 2.0 m) F = δφ/4."""
    force = Subsumption0().feelforce(far_except(ray10=2.0))
    expected = -ANGLE_RAD / 4.0 * np.array([math.cos(BEARINGS_RAD[10]), math.sin(BEARINGS_RAD[10])])
    assert [force.ahead[0], force.left[0]] == pytest.approx(expected.tolist(), rel=1e-5)


def test_two_things_push_with_the_sum() -> None:
    both = Subsumption0().feelforce(far_except(ray2=1.0, ray13=1.0))
    assert both.left[0] == pytest.approx(0.0, abs=1e-6)
    assert both.ahead[0] == pytest.approx(-2.0 * ANGLE_RAD * math.cos(BEARINGS_RAD[2]), rel=1e-5)


def test_runaway_is_silent_below_its_threshold() -> None:
    """At 1 m |F| = δφ = 0.196 per square metre."""
    assert Subsumption0(threshold=0.197).decide(BESIDE)[0].tolist()[0][LEFT] == 0.0
    assert Subsumption0(threshold=0.195).decide(BESIDE)[0].tolist()[0][LEFT] > 0.0


def test_runaway_turns_from_its_way_ahead_by_the_force() -> None:
    """The direction of (1 − k F cos φ, −k F sin φ)."""
    q_values, _ = replace(LEVEL_0, gain=3.0).decide(BESIDE)
    push, bearing = 3.0 * ANGLE_RAD, float(BEARINGS_RAD[10])
    expected = math.atan2(-push * math.sin(bearing), 1.0 - push * math.cos(bearing))
    assert q_values[0, LEFT] == pytest.approx(expected, rel=1e-5)


@pytest.mark.parametrize("periods", [1, 2, 5])
def test_avoid_replaces_runaway_as_it_speaks_and_for_its_time_after(periods: int) -> None:
    """Silent for three decisions, speaking for three, silent again."""
    speaks = replace(LEVEL_1, time_constant_s=0.1 * periods)
    silent = replace(speaks, mute=(Module.AVOID,))
    script = [silent] * 3 + [speaks] * 3 + [silent] * 8
    runaway = float(LEVEL_0.decide(BESIDE)[0][0, LEFT])
    found = headings(script, BESIDE)
    of_avoid = headings([speaks], BESIDE)[0]
    assert of_avoid != runaway
    assert found[:3] == [runaway] * 3
    held = 3 + periods - 1
    assert len(set(found[3 : 3 + held])) == 1
    assert runaway not in found[3 : 3 + held]
    assert found[3 + held :] == [runaway] * (8 - periods + 1)


@pytest.mark.parametrize("module", [Module.WANDER, Module.AVOID])
def test_with_level_1_mute_level_0_is_bit_for_bit_what_it_is_alone(module: Module) -> None:
    """Also where the force is below the threshold, and nobody speaks: in half of these."""
    retinas = assorted(500)
    level_0 = replace(LEVEL_0, threshold=5.0)
    level_1 = replace(LEVEL_1, threshold=5.0, mute=(module,))
    assert 0.2 < (level_0.decide(retinas)[0][:, LEFT] == 0.0).mean() < 0.8
    memory = unremembered(level_1.contract, 500)
    for _ in range(5):
        q_values, _, memory = level_1.decide(retinas, memory)
        assert q_values.tobytes() == level_0.decide(retinas)[0].tobytes()


@pytest.mark.parametrize("period_s", [0.1, 0.02])
def test_in_empty_space_headings_change_every_ten_seconds(period_s: float) -> None:
    level_1, count = replace(LEVEL_1, period_s=period_s), round(35.0 / period_s)
    found = headings([level_1] * count, EMPTY)
    changes = [k * period_s for k in range(1, count) if found[k] != found[k - 1]]
    assert changes == pytest.approx([10.0, 20.0, 30.0])
    assert all(abs(heading) <= 1.0 for heading in found)


def test_avoid_joins_the_heading_with_the_force() -> None:
    heading = headings([LEVEL_1], EMPTY)[0]
    # The dice see the retina, so the heading beside something is read where nothing pushes.
    beside = headings([replace(LEVEL_1, gain=0.0)], BESIDE)[0]
    push, bearing = LEVEL_1.gain * ANGLE_RAD, float(BEARINGS_RAD[10])
    expected = math.atan2(
        math.sin(beside) - push * math.sin(bearing), math.cos(beside) - push * math.cos(bearing)
    )
    assert headings([LEVEL_1], BESIDE)[0] == pytest.approx(expected, rel=1e-5)
    assert heading != beside


def test_a_body_that_turns_comes_round_to_the_heading_and_keeps_it() -> None:
    """It turns by 0.1 rad a decision: after |ψ| / 0.1 decisions it is there."""
    turning = (Action("stay", 1.0, 0.0), Action("left", 1.0, 0.0, 1.0), Action("right", 1, 0, -1))
    contract = replace(LEVEL_1.drives_by, actions=turning)
    level_1 = replace(LEVEL_1, drives_by=contract, dead_band_rad=0.06)
    first, *rest = headings([level_1] * 99, EMPTY)
    assert abs(first) > 0.1
    assert rest[0] == pytest.approx(first - math.copysign(0.1, first), rel=1e-5)
    assert all(abs(heading) <= 0.06 for heading in rest[math.ceil(abs(first) / 0.1) :])


def test_level_2_heads_for_the_farthest_passage() -> None:
    """Everything at 1 m; rays 4 to 6 at 4 m make a passage, ray 12 alone does not."""
    near = {f"ray{ray}": 1.0 for ray in range(16)}
    retina = far_except(**near | {"ray4": 4.0, "ray5": 4.0, "ray6": 4.0, "ray12": 5.0})
    plan = Subsumption(far_m=2.0).plan(retina)
    assert plan.is_sent.tolist() == [True]
    assert plan.values[0] == pytest.approx(BEARINGS_RAD[5], rel=1e-6)
    assert not Subsumption(far_m=4.5).plan(retina).is_sent[0]


def test_what_lies_beyond_the_edge_of_the_eye_is_no_passage() -> None:
    near = {f"ray{ray}": 1.0 for ray in range(16)}
    plan = Subsumption(far_m=2.0).plan(far_except(**near | {"ray0": 5.0, "ray1": 5.0}))
    assert not plan.is_sent[0]


def test_of_equal_passages_level_2_takes_the_one_nearest_to_ahead() -> None:
    assert Subsumption().plan(EMPTY).values[0] == pytest.approx(BEARINGS_RAD[7], rel=1e-6)


def test_plan_replaces_wanders_heading_and_gives_it_back_after_its_time() -> None:
    level_2 = Subsumption(dead_band_rad=0.0, widest_rad=1.0, time_constant_s=0.3)
    mute = replace(level_2, mute=(Module.PLAN,))
    found = headings([mute] * 2 + [level_2] * 2 + [mute] * 5, EMPTY)
    wander, plan = found[0], pytest.approx(BEARINGS_RAD[7], rel=1e-5)
    assert found == [wander] * 2 + [plan] * 4 + [wander] * 3


def test_with_plan_mute_level_2_is_bit_for_bit_level_1() -> None:
    retinas = assorted(200)
    level_1, level_2 = Subsumption1(), replace(Subsumption(), mute=(Module.PLAN,))
    same = replace(level_1, **{name: getattr(level_2, name) for name in ("gain", "dead_band_rad")})
    same = replace(same, widest_rad=level_2.widest_rad, threshold=level_2.threshold)
    lower = unremembered(same.contract, 200)
    upper = unremembered(level_2.contract, 200)
    for _ in range(5):
        q_lower, _, lower = same.decide(retinas, lower)
        q_upper, _, upper = level_2.decide(retinas, upper)
        assert q_lower.tobytes() == q_upper.tobytes()


@pytest.mark.parametrize("name", ["subsumption-0", "subsumption-1", "subsumption"])
def test_every_level_beats_random_motion_on_the_reference_field(name: str) -> None:
    policy: Baseline | Remembering = baseline_named(name)
    random = measure(RandomPolicy(1), Subsumption0().contract, agents=128, steps=200)
    assert measure(policy, policy.contract, agents=128, steps=200).high < random.low
