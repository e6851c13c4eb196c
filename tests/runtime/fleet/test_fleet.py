"""Every robot on a bus, as heard: who is there, who fell silent, and what a flood displaces."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.fleet.fleet import MOST_ALIKE, MOST_ROBOTS, MOST_TOKENS, Fleet
from reflexarc_runtime.fleet.views import FleetView
from reflexarc_runtime.messages.wire import TOO_LARGE, Message
from support.fleet_words import BODY, FIRST, SECOND, SECOND_RUNTIME, lease, message, status


def heard(*messages: Message) -> Fleet:
    fleet = Fleet()
    for each in messages:
        fleet.hear(each)
    return fleet


def at(fleet: Fleet, seconds: float) -> FleetView:
    return fleet.view(round(seconds * SECOND))


def names(fleet: FleetView) -> list[str]:
    return [one.robot for one in fleet.robots]


def test_robots_stand_in_the_order_of_their_names_whoever_speaks_first():
    said = [status(name) for name in ("robot10", "cart", "robot2", "robot1")]
    assert names(at(heard(*said), 0)) == ["cart", "robot1", "robot2", "robot10"]
    assert names(at(heard(*reversed(said)), 0)) == ["cart", "robot1", "robot2", "robot10"]


def test_a_runtime_and_its_body_are_one_robot_and_the_lease_says_who_drives():
    (one,) = at(heard(status(), lease(holder=FIRST, armed=True)), 0.5).robots
    (runtime,), (body,) = one.runtimes, one.bodies
    assert runtime.holds_lease
    assert body.lease is not None
    assert body.lease.armed
    assert (runtime.age_s, body.age_s) == (0.5, 0.5)


def test_a_robot_without_a_runtime_and_a_body_without_one_are_shown_alike():
    fleet = heard(status("a"), lease("b"), status("c", BODY, node="body", guard="on"))
    a, b, c = at(fleet, 0).robots
    assert (len(a.runtimes), len(a.bodies), a.body) == (1, 0, None)
    assert (len(b.runtimes), len(b.bodies), b.runtime) == (0, 1, None)
    assert c.body is not None
    assert (c.body.said.guard, c.body.lease) == ("on", None)


def test_two_runtimes_of_one_robot_are_both_shown_and_the_holder_stands_for_it():
    fleet = heard(status(ticks=1), status(sender=SECOND_RUNTIME, ticks=2))
    assert at(fleet, 0).robots[0].runtime == at(fleet, 0).robots[0].runtimes[0]
    fleet.hear(lease(holder=SECOND_RUNTIME))
    (one,) = at(fleet, 0).robots
    assert [each.said.ticks for each in one.runtimes] == [1, 2]
    assert one.runtime is not None
    assert one.runtime.said.ticks == 2


def test_a_node_is_silent_after_three_seconds_and_gone_after_thirty():
    fleet = heard(status(), lease(holder=FIRST))
    fleet.hear(lease(at_s=2.0))
    (one,) = at(fleet, 2.9).robots
    assert [one.runtimes[0].is_silent, one.bodies[0].is_silent] == [False, False]
    (one,) = at(fleet, 3.0).robots
    assert [one.runtimes[0].is_silent, one.bodies[0].is_silent] == [True, False]
    assert at(fleet, 5.0).silent == 2
    assert at(fleet, 29.9).robots[0].runtimes
    assert not at(fleet, 30.0).robots[0].runtimes
    assert at(fleet, 32.0).robots == ()


def test_a_silent_body_no_longer_says_who_drives():
    fleet = heard(lease(holder=FIRST), status(at_s=4.0))
    assert not at(fleet, 4.0).robots[0].runtimes[0].holds_lease


def test_no_clock_but_the_listener_s_counts():
    """Their stamps are of yesterday, of tomorrow and backwards."""
    fleet = Fleet()
    for second, stamp_ns in enumerate((9**18, 0, 5, 4)):
        fleet.hear(status(at_s=second, stamp_ns=stamp_ns, ticks=second))
    (runtime,) = at(fleet, 3.25).robots[0].runtimes
    assert (runtime.age_s, runtime.said.ticks, runtime.is_silent) == (0.25, 3, False)


def test_the_verdicts_of_the_last_period_are_what_two_statuses_differ_by():
    fleet = heard(status(verdicts={"OK": 40, "RECOVERING": 3}))
    assert at(fleet, 0).robots[0].runtimes[0].period_verdicts is None
    fleet.hear(status(verdicts={"OK": 88, "RECOVERING": 3, "STUCK": 2}))
    assert at(fleet, 0).robots[0].runtimes[0].period_verdicts == {"OK": 48, "STUCK": 2}


def test_a_stand_in_says_that_the_loop_is_late_and_takes_no_count_away():
    fleet = heard(status(ticks=900, rate_hz=50.0, verdicts={"OK": 900}, verdict=pb.OK, action="l"))
    late = {"verdict": pb.OVERRUN, "is_stand_in": True, "watchdog": "the loop is late: 90 ms"}
    fleet.hear(status(at_s=1.0, verdicts={"OVERRUN": 1}, **late))
    said = at(fleet, 1.0).robots[0].runtimes[0].said
    assert (said.ticks, said.rate_hz, dict(said.verdicts)) == (900, 50.0, {"OK": 900})
    assert (said.verdict, said.action, said.watchdog) == ("OVERRUN", "", late["watchdog"])
    fleet.hear(status(at_s=2.0, ticks=950, verdicts={"OK": 950}, verdict=pb.OK))
    runtime = at(fleet, 2.0).robots[0].runtimes[0]
    assert (runtime.said.is_stand_in, runtime.period_verdicts) == (False, {"OK": 50})


GARBAGE = {
    "no protobuf": replace(status(), payload=b"\xff" * 9),
    "a lease that is none": replace(lease(), payload=b"\x0a\xff"),
    "another encoding": replace(status(), encoding="text/plain"),
    "no stamp": replace(status(), attachment=b""),
    "a node of no kind": status(node="toaster"),
    "too large": replace(status(), payload=TOO_LARGE),
    "another key": replace(status(), key="robot0/pose"),
    "a deeper key": replace(status(), key="a/b/status"),
    "no robot's key": replace(status(), key="status"),
}


@pytest.mark.parametrize("garbage", GARBAGE.values(), ids=GARBAGE)
def test_garbage_is_counted_and_nothing_else(garbage: Message):
    fleet = heard(status("real"), garbage)
    seen = at(fleet, 0)
    assert (names(seen), seen.unreadable, seen.left_out) == (["real"], 1, 0)


@given(st.text(max_size=20), st.binary(max_size=60), st.binary(max_size=40), st.sampled_from("sl"))
def test_whatever_comes_on_those_keys_is_no_exception(
    name: str, payload: bytes, attachment: bytes, kind: str
):
    model = status() if kind == "s" else lease()
    key = f"{name}/{'status' if kind == 's' else 'lease'}"
    fleet = heard(replace(model, key=key, payload=payload))
    fleet.hear(replace(model, attachment=attachment))
    fleet.announced(f"{name}/alive/{name}", 0, is_there=True)
    at(fleet, 1.0)


def test_a_status_of_a_younger_version_is_read_as_far_as_it_is_known():
    """Field 1999 is nobody's yet, nor is verdict 77."""
    model = status(ticks=7, verdicts={"OK": 5, "HOVERING": 2})
    unknown = b"\xf8\x7c\x05" + b"\x98\x08\x4d"  # field 1999 = 5; field 131 = 77
    said = at(heard(replace(model, payload=model.payload + unknown)), 0).robots[0].runtimes[0].said
    assert (said.ticks, dict(said.verdicts)) == (7, {"OK": 5, "OTHER": 2})
    assert said.verdict == "OTHER"


def test_names_with_control_characters_are_shown_and_obeyed_by_no_terminal():
    fleet = heard(status("\x1b[2Jrobot\n"), status("r" * 5000), status(policy="\x1b]0;x\x07"))
    assert names(at(fleet, 0)) == ["\\x1b[2Jrobot\\n", "robot0", "r" * 64]
    assert at(fleet, 0).robots[1].runtimes[0].said.policy == "\\x1b]0;x\\x07"


@pytest.mark.parametrize("rate_hz", [float("nan"), float("inf"), -1.0])
def test_a_rate_that_is_none_is_not_known(rate_hz: float):
    said = at(heard(status(rate_hz=rate_hz)), 0).robots[0].runtimes[0].said
    assert said.rate_hz is None


def test_a_flood_of_names_displaces_no_robot_that_is_heard_and_is_counted():
    fleet = Fleet()
    for second in range(8):
        fleet.hear(status("real", at_s=second))
        for number in range(1250):
            fleet.hear(status(f"false{second}-{number}", at_s=second + 0.5))
    seen = at(fleet, 7.5)
    assert "real" in names(seen)
    assert len(seen.robots) == MOST_ROBOTS
    assert seen.left_out > 8000
    fleet.hear(status("late", at_s=12.0))
    assert "late" in names(at(fleet, 12.0))  # there is room again: the false ones are silent


def test_robots_that_only_announce_themselves_fill_the_room_and_make_it_again():
    fleet = Fleet()
    for number in range(MOST_ROBOTS + 1):
        is_new = fleet.announced(f"r{number}/alive/body", 0, is_there=True)
        assert is_new == (number < MOST_ROBOTS)
    seen = at(fleet, 0)
    assert (len(seen.robots), seen.left_out) == (MOST_ROBOTS, 1)
    assert "late" not in names(heard_at(fleet, 2.9))
    assert "late" in names(heard_at(fleet, 3.0))  # they have been silent since
    assert len(at(fleet, 3.0).robots) == MOST_ROBOTS


def heard_at(fleet: Fleet, seconds: float) -> FleetView:
    fleet.hear(status("late", at_s=seconds))
    return at(fleet, seconds)


def test_a_flood_of_senders_displaces_no_runtime_that_is_heard():
    fleet = heard(status(ticks=5))
    for number in range(1000):
        fleet.hear(status(sender=number.to_bytes(16, "big"), at_s=1.0))
        fleet.hear(lease(sender=number.to_bytes(16, "big"), at_s=1.0))
    (one,) = at(fleet, 1.0).robots
    assert (len(one.runtimes), len(one.bodies)) == (MOST_ALIKE, MOST_ALIKE)
    assert FIRST in [each.sender for each in one.runtimes]
    assert at(fleet, 1.0).left_out == 2000 - 2 * MOST_ALIKE + 1


def test_texts_reasons_and_phases_are_bounded():
    phases = [pb.PhaseTimes(phase=f"{n}", octaves=[1] * 500, least_bits=900) for n in range(500)]
    fleet = heard(
        status(policy="p" * 10_000, phases=phases, verdicts={f"V{n}": 1 for n in range(500)}),
        lease(refused={f"reason {n}": 1 for n in range(500)}, stopped="s" * 10_000),
    )
    (one,) = at(fleet, 0).robots
    said, held = one.runtimes[0].said, one.bodies[0].lease
    assert held is not None
    assert (len(said.policy), len(held.stopped)) == (120, 120)
    assert (len(said.phases), dict(said.verdicts)) == (16, {"OTHER": 500})
    assert (len(held.refused), sum(held.refused.values())) == (17, 500)


def test_tokens_name_who_announces_itself_and_go_when_it_does():
    fleet = Fleet()
    assert fleet.announced("r/alive/body", 0, is_there=True)
    assert not fleet.announced("r/alive/body", 0, is_there=True)
    assert at(fleet, 100.0).robots[0].nodes == ("body",)
    for number in range(100):
        fleet.announced(f"r/alive/{number}", 0, is_there=True)
    assert len(at(fleet, 100.0).robots[0].nodes) == MOST_TOKENS
    for node in at(fleet, 100.0).robots[0].nodes:
        fleet.announced(f"r/alive/{node}", 0, is_there=False)
    fleet.announced("unknown/alive/body", 0, is_there=False)
    assert at(fleet, 100.0).robots == ()


def test_it_says_whether_a_node_is_new():
    fleet = Fleet()
    assert [fleet.hear(status()), fleet.hear(status()), fleet.hear(lease())] == [True, False, True]
    assert not fleet.hear(message("a/status", b"", "reflexarc.Lease"))
