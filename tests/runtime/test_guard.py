"""The guard: what is free is done, else the next best, else slower, else nothing."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime.beams import Beams, fan_of
from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import BeamRule, RetinaSpec, Shading
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import SAFE_ACTION, Decision, Verdict
from reflexarc_runtime.errors import ContractError, LogError, UsageError
from reflexarc_runtime.guard import SHARES, STAND, Answer, Guard, answers
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp
from reflexarc_runtime.sensing.distances import beams_of_retina
from reflexarc_runtime.sensing.senses import sense_for
from support.policies import ScriptedPolicy
from support.sensing import ENCODING, KEY, MS
from support.slow_sweep import first_touch_s

AHEAD = (Action("stay", 1.0, 0.0), Action("left", 1.0, 1.0), Action("right", 1.0, -1.0))
DISC = GuardSettings(footprint=Footprint(radius_m=0.2), margin_m=0.05)
BEAMS = 181
THIN_M = 0.001
NOTHING = math.inf


def scan(**at: float) -> Beams:
    """Beams over a half circle that meet nothing, but for those named by their degrees."""
    ranges_m = np.full(BEAMS, NOTHING)
    for name, distance_m in at.items():
        ranges_m[90 + int(name.removeprefix("d").replace("m", "-"))] = distance_m
    return Beams(fan_of(-math.pi / 2, math.pi / (BEAMS - 1), BEAMS), ranges_m)


def guard_of(settings: GuardSettings = DISC, valid_for_s: float = 0.1) -> Guard:
    return Guard(settings, AHEAD, valid_for_s)


def share_ahead(settings: GuardSettings, distance_m: float, age_s: float = 0.0) -> float:
    return guard_of(settings).share((1.0, 0.0, 0.0), scan(d0=distance_m), age_s)


@pytest.mark.parametrize(
    ("settings", "age_s", "need_m"),
    [
        (GuardSettings(margin_m=THIN_M), 0.0, 0.1),  # 1 m/s for 0.1 s
        (GuardSettings(margin_m=THIN_M), 0.05, 0.15),
        (GuardSettings(margin_m=THIN_M, delay_s=0.2), 0.05, 0.35),
        (GuardSettings(margin_m=THIN_M, deceleration_mps2=1.0), 0.0, 0.6),  # and 1² / 2
        (GuardSettings(margin_m=0.05), 0.0, 0.15),
        (replace(DISC, delay_s=0.1, deceleration_mps2=2.0), 0.03, 0.25 + 0.23 + 0.25),
    ],
)
def test_the_way_is_that_of_age_validity_delay_and_braking(settings, age_s, need_m):
    assert share_ahead(settings, need_m + 2 * THIN_M, age_s) == 1.0
    assert share_ahead(settings, need_m - 2 * THIN_M, age_s) < 1.0


def test_the_share_is_the_largest_whose_way_is_free():
    braking = GuardSettings(margin_m=THIN_M, deceleration_mps2=1.0)
    for share in SHARES:
        need_m = share * 0.1 + share**2 / 2
        assert share_ahead(braking, need_m + 2 * THIN_M) == share
    assert share_ahead(braking, 0.05) == 0.0


def test_a_body_without_any_width_is_refused_because_no_beam_would_ever_meet_it():
    with pytest.raises(UsageError, match=r"0\.001 or more, got 0"):
        GuardSettings(margin_m=0.0)


@pytest.mark.parametrize("unknown", [math.nan, 0.0, -1.0, -math.inf])
def test_what_was_not_measured_is_not_free(unknown):
    assert share_ahead(DISC, unknown) == 0.0
    assert guard_of().share((0.0, -1.0, 0.0), scan(d30=unknown), 0.0) == 1.0  # away from it


def test_no_motion_leads_out_of_sight():
    guard = guard_of()
    assert guard.share((-1.0, 0.0, 0.0), scan(), 0.0) == 0.0
    assert guard.share((0.0, 1.0, 0.0), scan(), 0.0) == 1.0
    assert guard.share((0.0, 1.0, 2.0), scan(), 0.0) == 0.0  # it bends out of the half circle
    assert guard.share((0.0, 0.0, 2.0), scan(), 0.0) == 1.0  # a disc on the spot
    circle = Beams(fan_of(-math.pi, math.pi / 180, 360), np.full(360, NOTHING))
    assert guard.share((-1.0, 0.0, 0.0), circle, 0.0) == 1.0


def test_who_evades_in_good_time_still_has_somewhere_to_go():
    guard, values = guard_of(replace(DISC, evade_s=0.4)), (0.9, 0.2, 0.5)
    assert guard.answer(0, values, scan(d0=0.7), 0.0) == Answer(2, 1.0)
    assert guard.answer(0, values, scan(d0=0.8), 0.0) == Answer(0, 1.0)
    boxed = scan(d0=0.7, d45=0.7, dm45=0.7)
    assert guard.answer(0, values, boxed, 0.0) == Answer(0, 1.0)  # nothing is free so long


def test_what_is_free_is_done_else_the_next_best_else_slower_else_nothing():
    guard, values = guard_of(), (0.9, 0.2, 0.5)
    assert guard.answer(0, values, scan(), 0.0) == Answer(0, 1.0)
    assert guard.answer(0, values, scan(d20=0.34), 0.0) == Answer(2, 1.0)
    wall = scan(**{f"d{k}": 0.31 for k in range(91)}, **{f"dm{k}": 0.31 for k in range(1, 91)})
    assert guard.answer(0, values, wall, 0.0) == Answer(0, 0.5)
    only_stops = guard_of(replace(DISC, may_slow=False))
    assert only_stops.answer(0, values, wall, 0.0) == STAND
    close = scan(**{f"d{k}": 0.25 for k in range(91)}, **{f"dm{k}": 0.25 for k in range(1, 91)})
    assert guard.answer(0, values, close, 0.0) == STAND
    assert guard.answer(0, values, None, 0.0) == STAND


ranges = st.one_of(st.floats(0.2, 3.0), st.just(NOTHING), st.sampled_from([math.nan, 0.0]))
footprints = st.sampled_from(
    [Footprint(), Footprint(0.2), Footprint(ahead_m=0.3, behind_m=0.2, half_width_m=0.15)]
)
speeds = st.integers(-10, 10).map(lambda v: v / 8.0)
some_actions = st.lists(st.tuples(speeds, speeds, speeds), min_size=2, max_size=5)


@settings(max_examples=80, deadline=None)
@given(
    st.data(),
    footprints,
    some_actions,
    st.booleans(),
    st.sampled_from([None, 1.0]),
    st.floats(0, 1),
)
def test_many_agents_are_guarded_as_each_alone(data, outline, motions, slow, braking, age_s):
    known = GuardSettings(footprint=outline, may_slow=slow, deceleration_mps2=braking)
    actions = tuple(Action(str(i), *twist) for i, twist in enumerate(motions))
    guard, agents, rays = Guard(known, actions, 0.1), 6, 9
    row = st.lists(ranges, min_size=rays, max_size=rays)
    seen = np.array(data.draw(st.lists(row, min_size=agents, max_size=agents)))
    values = data.draw(
        st.lists(
            st.sampled_from([0.0, 0.25, 0.5, 1.0]), min_size=len(actions), max_size=len(actions)
        )
    )
    wanted = np.array([i % len(actions) for i in range(agents)])
    fan = fan_of(1.4, -0.35, rays)
    q_values = np.tile(np.array(values, np.float32), (agents, 1))
    done, shares = answers(guard, wanted, q_values, Beams(fan, seen), age_s)
    for i in range(agents):
        alone = guard.answer(int(wanted[i]), values, Beams(fan, seen[i]), age_s)
        assert alone.share == shares[i]
        assert alone.action is None if shares[i] == 0.0 else alone.action == done[i]


@settings(max_examples=80, deadline=None)
@given(st.lists(st.floats(0.3, 2.0), min_size=9, max_size=9), footprints, speeds, speeds)
def test_a_free_way_meets_no_point_on_it_and_one_that_is_not_does(seen, outline, lateral, angular):
    twist, known = (1.0, lateral, angular), GuardSettings(footprint=outline, deceleration_mps2=1.0)
    guard, fan = Guard(known, AHEAD, 0.1), fan_of(1.4, -0.35, 9)
    share = guard.share(twist, Beams(fan, np.array(seen)), 0.02)
    spots = [(r * c, r * s) for r, c, s in zip(seen, fan.cos, fan.sin, strict=True)]
    speed = math.hypot(1.0, lateral)
    if outline.ahead_m:
        speed += abs(angular) * outline.reach_m
    need_s = [s * 0.12 + s * s * speed / 2.0 for s in SHARES]
    if share > 0.0:
        until_s = need_s[SHARES.index(share)]
        assert first_touch_s(spots, outline, 0.05 - 2e-3, twist, until_s, 2e-3) > until_s - 2e-3
    out = abs(math.atan2(lateral, 1.0) + 0.5 * angular * need_s[0]) > 1.57
    if share < 1.0 and not out and abs(math.atan2(lateral, 1.0)) < 1.57:
        until_s = need_s[SHARES.index(share) - 1] if share else need_s[-1]
        assert first_touch_s(spots, outline, 0.05 + 4e-3, twist, until_s + 4e-3, 1e-3) < math.inf


def test_a_ray_tells_the_farthest_that_its_thing_can_be():
    spec = RetinaSpec(rays=4, range_m=5.0)
    beams = beams_of_retina(np.array([0, 51, 128, 255], np.uint8).reshape(1, 4, 1), spec)
    assert beams.ranges_m == pytest.approx([5.0, 4.0, 2.49, 0.0], abs=0.011)
    assert (beams.ranges_m <= 5.0 * (1.0 - np.array([0, 51, 128, 255]) / 255)).all()
    assert np.arctan2(beams.fan.sin, beams.fan.cos)[0] == pytest.approx(3 * math.pi / 8)
    assert beams.fan.sees(math.pi / 2)
    assert not beams.fan.sees(math.pi / 2 + 0.01)


@pytest.mark.parametrize(
    ("spec", "words"),
    [
        (RetinaSpec(shading=Shading.COLOUR), "colour shading"),
        (RetinaSpec(eyes=2, baseline_m=0.1), "2 eyes"),
        (RetinaSpec(channels=3), "3 channels"),
        (RetinaSpec(samples=4, beams=BeamRule.NEAREST_BEAM), "mean of 4"),
    ],
)
def test_a_retina_that_tells_no_range_is_refused_in_one_line_with_the_way_out(spec, words):
    with pytest.raises(ContractError, match=rf"{words}.*--no-guard") as refused:
        sense_for("retina", spec, guarded=True)
    assert "\n" not in str(refused.value)
    sense_for("retina", spec)


def test_a_ray_that_shows_the_nearest_of_its_samples_tells_a_range():
    assert (
        sense_for(
            "retina", RetinaSpec(samples=4, beams=BeamRule.SECTOR_MINIMUM), guarded=True
        ).topic.name
        == "retina"
    )


def test_settings_survive_and_damage_is_said():
    known = replace(DISC, delay_s=0.25, deceleration_mps2=1.5, may_slow=False)
    assert GuardSettings.from_json(known.to_json()) == known
    for text in ("{", "[]", "{}", '{"margin_m": 1}'):
        with pytest.raises(LogError, match="guard"):
            GuardSettings.from_json(text)
    with pytest.raises(UsageError, match=r"guard\.margin_m: expected 0.001 or more, got -1"):
        GuardSettings(margin_m=-1.0)


CONTRACT = PolicyContract(retina=RetinaSpec(rays=16), recovery_inputs=1, hold_s=0.2)


def drive(values: np.ndarray, contract: PolicyContract = CONTRACT) -> tuple[list[Decision], State]:
    """One tick a retina of these values, (ticks, rays), for a policy that wants its second."""
    sense = sense_for("retina", contract.retina, guarded=True)
    guard = Guard.for_contract(GuardSettings(), contract)
    controller = Controller(ScriptedPolicy(), contract, sense, "hash", guard=guard)
    state, decisions = State(), []
    for slot, rays in enumerate(values):
        at_ns = slot * 20 * MS
        payload = encode_retina(rays.reshape(contract.retina.shape), contract.retina, at_ns)
        message = Message(KEY, payload, ENCODING, pack_stamp(Stamp(slot, at_ns)), at_ns)
        state, decision = controller.step(state, Inputs((message,), slot), at_ns)
        decisions.append(decision)
    return decisions, state


def test_the_controller_does_what_the_guard_lets_it_do_and_says_so():
    free, left, walled = np.zeros(16, np.uint8), np.zeros(16, np.uint8), np.full(16, 254, np.uint8)
    left[:5] = 250
    (ok, guarded, stuck), state = drive(np.stack([free, left, walled]))
    assert (ok.verdict, ok.action, ok.reason) == (Verdict.OK, 1, "")
    assert (guarded.verdict, guarded.action, guarded.winner) == (Verdict.GUARDED, 2, 1)
    assert guarded.reason == "left is not free: right at 100%"
    command = guarded.command
    assert (command.verdict, command.action, command.lateral_mps) == (Verdict.GUARDED, 2, -1.0)
    assert not command.is_safe
    assert (stuck.verdict, stuck.action, stuck.winner) == (Verdict.STUCK, SAFE_ACTION, 1)
    assert (stuck.command.verdict, stuck.command.linear_mps) == (Verdict.STUCK, 0.0)
    assert stuck.command.is_safe
    assert state.hold is None


def test_a_slower_motion_is_a_guarded_one_with_its_speed_scaled():
    walled = np.full((1, 16), round(255 * (1 - 0.12 / 5.0)), np.uint8)
    ((decision,), _) = drive(walled)
    assert decision.verdict is Verdict.GUARDED
    assert decision.command.linear_mps in SHARES[1:]
    assert decision.command.linear_mps == abs(decision.command.lateral_mps) or not (
        decision.command.lateral_mps
    )
