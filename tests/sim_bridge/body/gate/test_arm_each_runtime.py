from dataclasses import replace

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_runtime.messages.controls import encode_own_release
from reflexarc_runtime.messages.topics import ARM, RELEASE, RESET
from reflexarc_sim_bridge.body.body import Body
from reflexarc_sim_bridge.body.bridge import settings_anew
from reflexarc_sim_bridge.body.gate.gate import Gate
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL, Motion
from reflexarc_sim_bridge.body.gate.settings import GateSettings
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from support.gates import BODY, MS, ONE, OTHER, drive, message

SETTINGS = GateSettings(max_input_age_s=0.1, arm_each_runtime=True)
AHEAD = Motion(1.0)


def gate(*heard, settings: GateSettings = SETTINGS) -> Gate:
    """After messages, each with the time at which it came, in milliseconds."""
    one = Gate.closed(BODY, settings)
    for at_ms, each in heard:
        one = one.hear(each, at_ms * MS)
    return one


def does(one: Gate, at_ms: int) -> Motion:
    return one.obey(at_ms * MS, 0.02)[0]


ARMED = (0, message(ARM))


def test_an_arm_counts_for_the_first_runtime_that_comes():
    one = gate(ARMED, (10, drive(10 * MS)))
    assert does(one, 20) == AHEAD


def test_the_next_runtime_is_not_armed_after_the_first_fell_silent():
    """A runtime that was killed and started again has another identifier."""
    one = gate(ARMED, (10, drive(10 * MS)), (200, drive(200 * MS, OTHER)))
    assert one.lease.lease.holder == OTHER
    assert not one.armed
    assert does(one, 210) == STANDSTILL


def test_nor_after_the_first_gave_its_lease_back():
    release = message(RELEASE, encode_own_release("end"), ONE)
    one = gate(ARMED, (10, drive(10 * MS)), (20, release), (30, drive(30 * MS, OTHER)))
    assert one.lease.lease.holder == OTHER
    assert not one.armed


def test_the_same_runtime_drives_on_after_a_silence():
    one = gate(ARMED, (10, drive(10 * MS)), (500, drive(500 * MS)))
    assert does(one, 510) == AHEAD


def test_a_runtime_between_the_two_disarms_the_first_as_well():
    one = gate(ARMED, (10, drive(10 * MS)), (200, drive(200 * MS, OTHER)), (400, drive(400 * MS)))
    assert one.lease.lease.holder == ONE
    assert not one.armed


def test_the_next_runtime_drives_once_it_is_armed():
    came = (200, drive(200 * MS, OTHER))
    one = gate(
        ARMED, (10, drive(10 * MS)), came, (210, message(ARM)), (220, drive(220 * MS, OTHER))
    )
    assert does(one, 230) == AHEAD


def test_who_only_asks_for_the_lease_of_another_disarms_nobody():
    one = gate(ARMED, (10, drive(10 * MS)), (20, drive(20 * MS, OTHER)))
    assert does(one, 30) == AHEAD


def test_a_reset_disarms_and_the_next_arm_counts_for_whoever_holds_the_lease():
    one = gate(ARMED, (10, drive(10 * MS)), (20, message(RESET)))
    assert not one.armed
    one = one.hear(message(ARM), 30 * MS).hear(drive(40 * MS), 40 * MS)
    assert does(one, 50) == AHEAD


def test_without_the_setting_an_arm_counts_for_all():
    came = (200, drive(200 * MS, OTHER))
    settings = replace(SETTINGS, arm_each_runtime=False)
    one = gate(ARMED, (10, drive(10 * MS)), came, settings=settings)
    assert does(one, 210) == AHEAD


def test_a_body_cannot_arm_itself_and_be_armed_for_each_runtime():
    with pytest.raises(UsageError, match="got both"):
        GateSettings(max_input_age_s=0.1, auto_arm=True, arm_each_runtime=True)


@pytest.mark.parametrize("flag", ["hold_to_run", "arm_each_runtime", "lockstep", "auto_arm"])
def test_who_may_arm_a_body_does_not_change_when_its_eye_is_built_anew(flag):
    settings = GateSettings(0.1, **{flag: True})
    body = Body(world_named("reference-1").drawn(0), reference_contract(), 50.0, seed=0)
    assert getattr(settings_anew(body, settings), flag)
