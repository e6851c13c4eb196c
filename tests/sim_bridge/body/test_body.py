import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from reflexarc_runtime.contract.body_limits import BodyLimits
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.contract.motion import Action
from reflexarc_runtime.errors import WorldError
from reflexarc_runtime.messages.body_info import BodyInfo, decode_body, encode_body
from reflexarc_sim_bridge.body.body import Body, rebuild
from reflexarc_sim_bridge.body.foxglove_messages import encode_scene
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import parse_world, world_named, world_text
from reflexarc_sim_bridge.worlds.world import Senses, World, WorldSource

CONTRACT = PolicyContract()


def test_a_motion_moves_the_body_and_a_standstill_does_not():
    body = Body(world_named("reference-1").drawn(0), CONTRACT, 50.0, seed=0)
    begin_m = body.place.x_m
    body.move(STANDSTILL)
    assert body.place.x_m == begin_m
    body.move(Motion(1.0))
    assert body.place.x_m - begin_m == pytest.approx(0.02)


def test_a_contact_is_said_to_be_where_it_began_and_not_where_the_body_goes_on():
    body = Body(world_named("reference-1"), CONTRACT, 50.0, seed=0)
    for _ in range(2000):
        before = body.place
        met = body.move(CONTRACT.actions[0])
        if met is not None:
            assert (met.y_m, met.heading_rad) == (before.y_m, before.heading_rad)
            assert before.x_m <= met.x_m == body.place.x_m
            assert body.place.y_m != met.y_m
            return
    raise AssertionError("it drove 40 m through a quarter-covered field without a contact")


def body_in(name: str, rate_hz: float, seed: int, number: int = 0) -> Body:
    text = world_text(name)
    return Body(parse_world(text).drawn(seed), CONTRACT, rate_hz, seed, number, text)


@pytest.mark.parametrize("name", ["reference-1", "randomised", "crossing", "corridor-20"])
@pytest.mark.parametrize(("rate_hz", "seed", "number"), [(50.0, 0, 0), (49.0, 2**64 - 1, 3)])
def test_what_a_body_says_of_itself_builds_it_again(
    name: str, rate_hz: float, seed: int, number: int
):
    first = body_in(name, rate_hz, seed, number)
    told = decode_body(encode_body(first.info))
    assert told is not None
    again = rebuild(told, CONTRACT)
    assert again.info == first.info
    assert again.simulation.dt_s == first.simulation.dt_s
    for step in range(30):
        assert scene_of(again) == scene_of(first)
        assert np.array_equal(again.see(), first.see())
        assert again.place == first.place
        for body in (first, again):
            body.move(CONTRACT.actions[step % 3])


def scene_of(body: Body) -> bytes:
    return encode_scene(body.simulation.outlines_near(0), 0)


@dataclass
class Looks:
    """What an eye saw, step by step."""

    seen: list[bytes]
    step_s: float


def latency_s(late: Looks, now: Looks) -> float:
    """How old what one eye sees is, by what another one saw that sees at once."""
    ages = [age for age in range(40) if late.seen[40:] == now.seen[40 - age : len(now.seen) - age]]
    assert len(ages) == 1
    return ages[0] * late.step_s


def evaluated(world: WorldSource) -> Looks:
    """An agent of an evaluation, straight on."""
    simulation, seen = Simulation(world, CONTRACT, np.zeros(1, np.uint64)), []
    for _ in range(80):
        seen.append(simulation.sense().tobytes())
        simulation.step(np.zeros(1, np.int64))
    return Looks(seen, simulation.dt_s)


def simulated(world: WorldSource, rate_hz: float) -> Looks:
    """A body on the bus, straight on."""
    body, seen = Body(world.drawn(0), CONTRACT, rate_hz, 0), []
    for _ in range(round(8 * rate_hz)):
        seen.append(body.see().tobytes())
        body.move(CONTRACT.actions[0])
    return Looks(seen, body.info.step_s or 0.0)


@pytest.mark.parametrize("rate_hz", [10.0, 20.0, 50.0])
def test_a_body_sees_as_late_as_an_agent_that_is_evaluated(rate_hz: float):
    late, now = world_named("late"), world_named("reference-1")
    assert latency_s(evaluated(late), evaluated(now)) == pytest.approx(0.3)
    assert latency_s(simulated(late, rate_hz), simulated(now, rate_hz)) == pytest.approx(0.3)


def test_a_slow_sensor_sends_as_seldom_at_any_rate():
    """A gap of 1 to n steps: n is 0.4 s, and all are as likely."""
    slow = World("slow", senses=Senses(gap_s=0.4))
    for rate_hz, most in ((10.0, 4), (50.0, 20)):
        body, sent = Body(slow, CONTRACT, rate_hz, 0), []
        for step in range(3000):
            if body.sends_anew:
                sent.append(step)
            body.see()
            body.move(STANDSTILL)
        gaps = np.diff(sent)
        assert sent[0] == 0
        assert sorted(set(gaps.tolist())) == list(range(1, most + 1))
        spread = math.sqrt((most**2 - 1) / 12 / len(gaps))
        assert gaps.mean() == pytest.approx((most + 1) / 2, abs=4 * spread)


def test_a_latency_too_long_for_the_rate_is_refused_in_one_line():
    late = World("late", senses=Senses(latency_s=5.0))
    with pytest.raises(WorldError) as refusal:
        Body(late, CONTRACT, 1000.0, 0)
    assert str(refusal.value) == (
        "world.senses.latency_s: expected at most 1.024 s, 1024 steps of 0.001 s, got 5.0; "
        "a lower --rate makes the steps longer"
    )


def test_robots_of_one_world_say_different_numbers_and_stand_at_different_places():
    one, other = body_in("reference-1", 50.0, 0, 0), body_in("reference-1", 50.0, 0, 1)
    assert replace(one.info, number=1) == other.info
    assert one.place != other.place


def test_its_limits_are_the_fastest_of_the_actions_in_each_direction():
    actions = (Action("back", -2.0, 0.0), Action("left", 1.0, 0.5), Action("turn", 0.0, 0.0, -3.0))
    body = Body(world_named("reference-1").drawn(0), replace(CONTRACT, actions=actions), 50.0, 0)
    assert body.info.limits == BodyLimits(2.0, 0.5, 3.0)


def test_the_limits_of_its_world_narrow_them():
    text = world_text("reference-1") + "\n[limits]\nlinear_mps = 0.4\nvalid_for_s = 0.05\n"
    world = parse_world(text).drawn(0)
    limits = Body(world, CONTRACT, 50.0, 0, world_text=text).limits
    assert limits == BodyLimits(0.4, 1.0, 0.0, valid_for_s=0.05)


@pytest.mark.parametrize("info", [BodyInfo(), BodyInfo(step_s=0.1), BodyInfo("x", "name = 1")])
def test_a_body_that_was_not_simulated_cannot_be_built_again(info: BodyInfo):
    with pytest.raises(WorldError):
        rebuild(info, CONTRACT)


def test_a_body_too_fast_to_simulate_is_refused_before_anything_is_listed():
    for action in (Action("go", 1e308, 0.0), Action("slide", 0.0, 5001.0)):
        fast = replace(CONTRACT, actions=(*CONTRACT.actions, action))
        with pytest.raises(WorldError, match="100 m in a step"):
            Body(world_named("reference-1").drawn(0), fast, 50.0, 0)
    Body(world_named("reference-1").drawn(0), fast, 51.0, 0)


def test_a_body_whose_stop_is_faster_than_its_actions_meets_all_that_lies_in_its_way():
    rush = Action("rush", 200.0, 0.0)
    by_stop, by_action = (
        Body(world_named("reference-1").drawn(0), contract, 10.0, 0)
        for contract in (
            replace(CONTRACT, safe_command=rush),
            replace(CONTRACT, safe_command=rush, actions=(*CONTRACT.actions, rush)),
        )
    )
    for _ in range(50):  # nobody has told them to go
        assert by_stop.move(by_stop.safe) == by_action.move(by_action.safe)
    assert by_stop.contacts > 40


def contacts_and_way(
    contract: PolicyContract, *, checks: bool, steps: int = 1500, senses: Senses | None = None
) -> tuple:
    """What comes of driving straight on, whatever is in the way."""
    world = replace(world_named("rover").drawn(0), senses=senses or Senses())
    body = Body(world, contract, 20.0, seed=2, checks=checks)
    for _ in range(1, steps):
        body.move(contract.actions[0])
    return body.contacts, float(body.simulation.distance_m[0]), body.held_back, body.guard_state


def test_a_body_that_checks_for_itself_stands_before_it_would_touch():
    contract = PolicyContract(retina=RetinaSpec(rays=181))
    unchecked, far_m, _, off = contacts_and_way(contract, checks=False)
    contacts, way_m, held_back, on = contacts_and_way(contract, checks=True)
    assert (unchecked > 3, contacts, off, on) == (True, 0, "off", "on")
    assert 0.1 < way_m < far_m
    assert held_back > 100


@pytest.mark.parametrize("senses", [Senses(mounted_rad=1.0), Senses(permuted=1)])
def test_a_body_checks_where_its_eye_really_looks(senses: Senses):
    contract = PolicyContract(retina=RetinaSpec(rays=361, fov_rad=2 * math.pi))
    contacts, way_m, held_back, _ = contacts_and_way(contract, checks=True, senses=senses)
    _, straight_m, _, _ = contacts_and_way(contract, checks=True)
    assert contacts == 0
    assert way_m == pytest.approx(straight_m, abs=1e-6)
    assert held_back > 100


def test_a_body_with_two_eyes_cannot_check():
    contract = PolicyContract(retina=RetinaSpec(eyes=2, baseline_m=0.1))
    with pytest.raises(WorldError, match="expected one eye to check with, got 2"):
        Body(world_named("reference-1"), contract, 50.0, seed=0, checks=True)
