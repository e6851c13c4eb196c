"""A ride does what a simulation and a policy do in a plain loop, and goes back to the bit."""

import itertools
import math
from dataclasses import dataclass, replace

import numpy as np
import pytest

from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.messages.body_info import BodyInfo
from reflexarc_runtime.sensing.senses import sense_for
from reflexarc_runtime.serving.swapping import SwappingController
from reflexarc_sim_bridge.body.body import BodyPose, rebuild
from reflexarc_sim_bridge.body.driving_on import drive_on
from reflexarc_sim_bridge.body.ride import HandOver, Ride
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named, world_text

CONTRACT = replace(PolicyContract(), recovery_inputs=1)
INFO = BodyInfo("tier-30", world_text("tier-30"), 3, 0, 0.02)


@dataclass
class Darker:
    """Steers to the darker side; from `fails_from` on it fails."""

    fails_from: float = math.inf
    asked: int = 0

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        self.asked += 1
        if self.asked > self.fails_from:
            raise ValueError
        rays = retinas[:, -1, 0, :, 0].astype(np.float32)
        half = rays.shape[1] // 2
        q_values = np.stack(
            [-rays[:, half - 1], -rays[:, :half].mean(axis=1), -rays[:, half:].mean(axis=1)], axis=1
        ).astype(np.float32)
        return q_values, q_values.argmax(axis=1)


def ride(policy: Darker | None = None, every: int = 1, info: BodyInfo = INFO) -> Ride:
    sense = sense_for("retina", CONTRACT.retina)
    controller = Controller(policy or Darker(), CONTRACT, sense)
    return Ride(rebuild(info, CONTRACT, all_round=True), controller, every=every)


class Brighter(Darker):
    """Steers to the brighter side."""

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        q_values, _ = super().decide(retinas)
        return -q_values, (-q_values).argmax(axis=1)


def plain_drive(
    steps: int, brighter: range = range(0)
) -> tuple[list[tuple[float, float]], int | None]:
    """The same in a plain loop: places, and the step that ended in a contact."""
    world = replace(world_named("tier-30").drawn(3), dt_s=0.02)
    simulation = Simulation(world, CONTRACT, np.array([3], np.uint64))
    darker, places = Darker(), list[tuple[float, float]]()
    for step in range(steps):
        places.append((float(simulation.x_m[0]), float(simulation.y_m[0])))
        simulation.sense()
        policy = Brighter() if step in brighter else darker
        if simulation.step(policy.decide(simulation.stacks)[1])[0]:
            return places, step
    return places, None


def test_a_ride_is_the_plain_loop_of_a_policy_and_a_simulation():
    places, contact = plain_drive(2000)
    assert contact is not None
    way = drive_on(ride(), 0, 2000)
    assert way.contact_step == contact
    assert [(each.x_m, each.y_m) for each in way.places] == places
    assert way.not_asked == {}
    whole = sum(math.dist(a, b) for a, b in itertools.pairwise(places))
    assert way.driven_m == pytest.approx(whole, rel=1e-6)


def test_a_ride_goes_back_to_a_moment_and_drives_the_same_again():
    one = ride()
    for step in range(10):
        one.look(step * 20_000_000)
        one.obey(step * 20_000_000)
    kept = one.keep()
    first = drive_on(one, 200_000_000, 300)
    one.go_back(kept)
    assert drive_on(one, 200_000_000, 300) == first


def test_a_ride_that_is_led_is_where_the_other_one_was_and_goes_on_as_it():
    driven, led = ride(), ride()
    for step in range(12):
        now_ns = step * 20_000_000
        for each in (driven, led):
            each.look(now_ns)
        before = driven.keep().command
        motion = led.told(before, now_ns)
        driven.obey(now_ns)
        led.lead(motion)
        assert led.put(driven.body.place, step + 1) == 0.0
    assert drive_on(led, 240_000_000, 200) == drive_on(driven, 240_000_000, 200)


def test_a_policy_that_fails_stands_and_that_is_counted():
    way = drive_on(ride(Darker(fails_from=5)), 0, 40)
    assert way.contact_step is None
    assert way.not_asked == {"POLICY_FAULT": 35}
    assert way.driven_m == pytest.approx(5 * 0.02 * 1.0, rel=0.5)


def test_a_slower_loop_is_asked_at_every_few_steps_alone():
    policy = Darker()
    drive_on(ride(policy, every=5), 0, 20)
    assert policy.asked == 4


def test_the_nearest_is_the_least_room_of_all_places():
    one = ride()
    way = drive_on(one, 0, 25)
    assert way.contact_step is None
    rooms_m = []
    for place in way.places:
        one.put(place, 0)
        rooms_m.append(one.clearance_m)
    assert way.nearest_m == pytest.approx(min(rooms_m), abs=1e-5)
    assert 0.0 < way.nearest_m < max(rooms_m)


def test_a_place_far_off_is_put_and_how_far_it_was_is_said():
    one = ride()
    here = one.body.place
    assert one.put(here, 0) == 0.0
    there = BodyPose(here.x_m + 3.0, here.y_m, here.heading_rad)
    assert one.put(there, 150) == pytest.approx(3.0)
    assert one.body.place == there
    assert one.put(replace(there, heading_rad=2.0 * math.pi), 150) == pytest.approx(0.0, abs=1e-9)


def turning_ride(*turns: HandOver, second: Darker) -> Ride:
    """Under two policies that take turns."""
    sense = sense_for("retina", CONTRACT.retina)
    first = Controller(Darker(), CONTRACT, sense, "first")
    controller = SwappingController(
        first, {"second": replace(first, policy=second, policy_hash="second")}
    )
    return Ride(rebuild(INFO, CONTRACT, all_round=True), controller, hand_overs=turns)


def test_policies_take_turns_at_the_looks_at_which_they_did():
    places, contact = plain_drive(120, brighter=range(10, 20))
    alone, _ = plain_drive(120)
    assert places[:11] == alone[:11]
    assert places[11] != alone[11]
    turns = (
        HandOver(10 * 20_000_000, "second", "first"),
        HandOver(20 * 20_000_000, "first", "second"),
    )
    way = drive_on(turning_ride(*turns, second=Brighter()), 0, 120)
    assert [(each.x_m, each.y_m) for each in way.places] == places
    assert way.contact_step == contact == 31


def test_who_has_its_turn_behind_a_moment_has_it_again_when_the_ride_goes_back():
    one = turning_ride(HandOver(15 * 20_000_000, "second", "first"), second=Brighter())
    for step in range(10):
        one.look(step * 20_000_000)
        one.obey(step * 20_000_000)
    kept = one.keep()
    first = drive_on(one, 200_000_000, 60)
    one.go_back(kept)
    assert drive_on(one, 200_000_000, 60) == first
    whole = drive_on(
        turning_ride(HandOver(300_000_000, "second", "first"), second=Brighter()), 0, 70
    )
    assert first.places == whole.places[10:]


def test_who_fails_in_its_turn_is_followed_by_the_former_one():
    turn = HandOver(10 * 20_000_000, "second", "first")
    way = drive_on(turning_ride(turn, second=Darker(fails_from=5)), 0, 40)
    alone, _ = plain_drive(40)
    assert [(each.x_m, each.y_m) for each in way.places] == alone
    assert way.not_asked == {}
