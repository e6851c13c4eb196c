"""A guard with ranges from a topic of their own, for a policy that sees none."""

import math
from dataclasses import replace

import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan

from reflexarc_runtime.contract.body_spec import Footprint
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Decision, Verdict
from reflexarc_runtime.errors import LogError, UsageError
from reflexarc_runtime.guard import Guard
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.keyframe import decode_state, encode_state
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.messages_pb2 import Keyframe
from reflexarc_runtime.sensing.senses import sense_for
from support.policies import ScriptedPolicy
from support.sensing import MS, retina_message

CONTRACT = PolicyContract(
    retina=RetinaSpec(rays=4, channels=3, shading=Shading.COLOUR), recovery_inputs=1
)
SETTINGS = GuardSettings(footprint=Footprint(radius_m=0.2), ranges="scan", ranges_oldest_s=0.1)
LIDAR, BUMPER, BODY = b"lidar".ljust(16), b"bumper".ljust(16), b"body".ljust(16)
FREE = math.inf
TICK_MS = 20


def scan_message(
    number: int, at_ms: int, ranges: list[float] | None = None, sender: bytes = LIDAR
) -> Message:
    """Nine beams over 160 degrees."""
    seen = [FREE] * 9 if ranges is None else ranges
    payload = LaserScan(start_angle=-1.4, end_angle=1.4, ranges=seen).SerializeToString()
    stamp = pack_stamp(Stamp(number, at_ms * MS, sender))
    encoding = protobuf_encoding("foxglove.LaserScan")
    return Message("robot0/scan", payload, encoding, stamp, at_ms * MS)


def controller(settings: GuardSettings = SETTINGS) -> Controller:
    guard = Guard.for_contract(settings, CONTRACT)
    sense = sense_for("retina", CONTRACT.retina)
    return Controller(ScriptedPolicy(), CONTRACT, sense, "hash", guard=guard)


def drive(scans: dict[int, list[Message]], ticks: int) -> list[Decision]:
    """One colour retina a tick, and the scans of that tick in front of it."""
    mine, state, decisions = controller(), State(), []
    for slot in range(ticks):
        at_ns = slot * TICK_MS * MS
        messages = (*scans.get(slot, ()), retina_message(slot, at_ns, spec=CONTRACT.retina))
        state, decision = mine.step(state, Inputs(messages, slot), at_ns)
        decisions.append(decision)
        keyframe = Keyframe.FromString(encode_state(state, "hash"))
        assert encode_state(decode_state(keyframe, CONTRACT), "hash") == encode_state(state, "hash")
    return decisions


def verdicts(scans: dict[int, list[Message]], ticks: int) -> list[Verdict]:
    return [decision.verdict for decision in drive(scans, ticks)]


def test_without_ranges_or_with_old_ones_it_stands_and_says_why():
    decisions = drive({1: [scan_message(0, 20)]}, 9)
    assert [d.verdict for d in decisions] == [Verdict.STUCK] + [Verdict.OK] * 6 + [
        Verdict.STUCK
    ] * 2
    assert decisions[0].reason == "no ranges yet"
    assert decisions[-1].reason == "no ranges for 0.1 s"
    assert decisions[-1].command.is_safe


def test_a_pressed_sector_stops_what_leads_there_and_nothing_else():
    left, ahead = [FREE] * 8 + [0.0], [FREE] * 3 + [0.0] * 3 + [FREE] * 3
    pressed = drive({0: [scan_message(0, 0, left)], 1: [scan_message(1, 20, ahead)]}, 2)
    assert pressed[0].verdict is Verdict.GUARDED  # the policy wants to the left
    assert pressed[0].reason == "left is not free: right at 100%"
    assert pressed[1].verdict is Verdict.STUCK
    assert pressed[1].reason == "left is not free, nor is anything else"


def test_ranges_are_as_old_as_their_scan_whenever_the_retina_came():
    way_m = 0.2 + 0.05 + math.sqrt(2.0) * 0.1  # outline, margin, and validity
    wall = [way_m + math.sqrt(2.0) * 0.05] * 9  # room for an age of 50 ms
    decisions = drive({0: [scan_message(0, 0, wall)]}, 4)
    assert [d.reason for d in decisions] == ["", "", "", "left is not free: stay at 100%"]


@pytest.mark.parametrize(
    ("broken", "words"),
    [
        ({"payload": b"\xff"}, "no foxglove.LaserScan"),
        ({"attachment": b""}, "attachment"),
        ({"encoding": "text/plain"}, "encoding"),
        ({"payload": LaserScan(ranges=[1.0]).SerializeToString()}, "1 beams"),
        (
            {"payload": LaserScan(end_angle=math.nan, ranges=[1.0] * 9).SerializeToString()},
            "finite angles",
        ),
        ({"payload": LaserScan(end_angle=7.5, ranges=[1.0] * 9).SerializeToString()}, "to 7.5"),
        ({"payload": LaserScan(end_angle=-1.0, ranges=[1.0] * 9).SerializeToString()}, "to -1"),
    ],
)
def test_a_broken_scan_is_none_until_a_good_one_comes(broken, words):
    scans = {
        0: [scan_message(0, 0)],
        1: [replace(scan_message(1, 20), **broken)],
        3: [scan_message(2, 60)],
    }
    decisions = drive(scans, 4)
    assert [d.verdict.name for d in decisions] == ["OK", "STUCK", "STUCK", "OK"]
    assert decisions[1].reason.startswith("no ranges: ")
    assert words in decisions[1].reason


def test_a_second_range_sensor_is_not_believed_and_shows():
    wall = [0.0] * 9
    scans = {slot: [scan_message(slot, 20 * slot)] for slot in range(20)}
    scans[5].append(scan_message(0, 100, wall, sender=BUMPER))
    heard = verdicts(scans, 14)
    assert heard[:5] == [Verdict.OK] * 5
    assert heard[5:11] == [Verdict.TWO_SOURCES] * 6  # for 100 ms
    assert heard[11:] == [Verdict.OK] * 3  # and its wall was never looked at


def test_another_sensor_is_believed_when_the_first_has_been_silent_long_enough():
    scans = {0: [scan_message(9, 0)]}
    scans |= {slot: [scan_message(0, 20 * slot, sender=BUMPER)] for slot in range(7, 9)}
    heard = verdicts(scans, 9)
    assert heard[5:] == [Verdict.OK, Verdict.STUCK, Verdict.OK, Verdict.OK]


def test_a_repeated_scan_makes_no_range_younger():
    again = scan_message(0, 0)
    scans = {slot: [replace(again, received_ns=slot * TICK_MS * MS)] for slot in range(10)}
    assert verdicts(scans, 8)[5:] == [Verdict.OK, Verdict.STUCK, Verdict.STUCK]


def test_the_status_says_what_is_missing():
    mine = controller()
    assert mine.lack_of_ranges(State(), 0) == "no ranges yet"
    state, _ = mine.step(State(), Inputs((scan_message(0, 0),), 0), 0)
    assert mine.lack_of_ranges(state, 50 * MS) == ""
    assert mine.lack_of_ranges(state, 420 * MS) == "no ranges for 0.4 s"
    assert controller(replace(SETTINGS, ranges="")).lack_of_ranges(State(), 0) == ""


def test_settings_of_before_have_no_topic_of_their_own():
    text = replace(SETTINGS, inertia=False, ranges="", ranges_oldest_s=0.25).to_json()
    older = text.replace(', "ranges": "", "ranges_oldest_s": 0.25', "")
    older = older.replace('"inertia": false, ', "")
    assert older != text
    assert GuardSettings.from_json(older) == GuardSettings.from_json(text)
    assert GuardSettings.from_json(SETTINGS.to_json()) == SETTINGS
    with pytest.raises(UsageError, match=r"guard\.ranges: expected scan, got"):
        replace(SETTINGS, ranges="sonar")
    with pytest.raises((LogError, UsageError)):
        GuardSettings.from_json(SETTINGS.to_json().replace("0.1", "NaN"))


def test_ranges_out_of_a_queue_are_as_old_as_it_is_deep():
    at_once = {slot: [scan_message(slot, slot * TICK_MS)] for slot in range(4)}
    late = {
        slot + 100: [
            replace(scan_message(slot, slot * TICK_MS), received_ns=(slot + 100) * TICK_MS * MS)
        ]
        for slot in range(4, 8)
    }
    decisions = drive({**at_once, **late}, 108)
    assert {d.verdict for d in decisions[:4]} == {Verdict.OK}
    assert {d.verdict for d in decisions[104:]} == {Verdict.STUCK}
    assert decisions[-1].reason == "ranges 2.0 s behind its sender's best: a backlog"
