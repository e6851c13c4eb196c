from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.body_info import decode_body
from reflexarc_sim_bridge.body.body import Body
from reflexarc_sim_bridge.body.bridge import StatePublisher
from reflexarc_sim_bridge.body.gate.account import Account
from reflexarc_sim_bridge.body.gate.lease import Lease
from reflexarc_sim_bridge.body.gate.limits import STANDSTILL
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.world import Senses, World

STEP_NS = 250_000_000
ACCOUNT = Account(Lease(), armed=True, stopped="", state="waiting for a command")


class Spoken:
    """A publisher that remembers."""

    sender = bytes(16)

    def __init__(self) -> None:
        self.said: list[tuple[bytes, int]] = []

    def put(self, payload: bytes, time_ns: int) -> None:
        self.said.append((payload, time_ns))


class FakeBus:
    """Publishers by the names of their topics."""

    def __init__(self) -> None:
        self.publishers: dict[str, Spoken] = {}

    def publisher(self, topic: Any) -> Spoken:
        return self.publishers.setdefault(topic.name, Spoken())


def test_a_body_says_where_it_is_when_it_begins_and_then_every_two_seconds():
    bus: Any = FakeBus()
    body = Body(world_named("reference-1").drawn(7), PolicyContract(), 4.0, 7, 2, "its text")
    state = StatePublisher(bus, body, "robot0")
    for step in range(17):
        state.publish(None, ACCOUNT, step * STEP_NS)
    said = bus.publishers["body"].said
    assert [time_ns for _, time_ns in said] == [0, 8 * STEP_NS, 16 * STEP_NS]
    assert [time_ns for _, time_ns in bus.publishers["scene"].said] == [
        0,
        8 * STEP_NS,
        16 * STEP_NS,
    ]
    assert len(bus.publishers["status"].said) == 5
    assert len(bus.publishers["pose"].said) == 17
    assert {decode_body(payload) for payload, _ in said} == {body.info}
    assert (body.info.world, body.info.world_text) == ("reference-1", "its text")
    assert (body.info.seed, body.info.number, body.info.step_s) == (7, 2, 0.25)


def test_transforms_which_say_the_pose_again_come_ten_times_a_second():
    bus: Any = FakeBus()
    state = StatePublisher(bus, Body(World("still"), PolicyContract(), 50.0, 0), "robot0")
    for step in range(500):
        state.publish(None, ACCOUNT, step * 20_000_000)
    times_ns = [time_ns for _, time_ns in bus.publishers["tf"].said]
    assert times_ns == list(range(0, 500 * 20_000_000, 100_000_000))
    placed = {time_ns for _, time_ns in bus.publishers["pose"].said}
    assert set(times_ns) <= placed


@pytest.mark.parametrize("again", [False, True])
def test_a_slow_sensor_says_nothing_between_its_retinas_unless_every_step_needs_one(again: bool):
    bus: Any = FakeBus()
    world = World("slow", senses=Senses(gap_s=0.3))
    body = Body(world, PolicyContract(), 50.0, 0)
    state = StatePublisher(bus, body, "robot0")
    for step in range(2000):
        state.publish(None, ACCOUNT, step * 20_000_000, again=again)
        body.move(STANDSTILL)
    gaps = np.diff([time_ns // 20_000_000 for _, time_ns in bus.publishers["retina"].said])
    assert set(gaps) == ({1} if again else set(range(1, 16)))
    assert len(bus.publishers["pose"].said) == 2000


def test_the_lease_is_said_ten_times_a_second_and_at_once_when_it_changes():
    bus: Any = FakeBus()
    body = Body(world_named("reference-1").drawn(7), PolicyContract(), 4.0, 7)
    state = StatePublisher(bus, body, "robot0")
    armed = [True, True, False, False, False, False, False, True]
    for step, is_armed in enumerate(armed):
        state.publish(None, replace(ACCOUNT, armed=is_armed), step * 20_000_000)
    said = bus.publishers["lease"].said
    assert [time_ns // 20_000_000 for _, time_ns in said] == [0, 2, 5, 7]
    assert [pb.Lease.FromString(payload).armed for payload, _ in said] == [True, False, False, True]


def test_the_status_of_a_body_says_what_it_refused():
    bus: Any = FakeBus()
    body = Body(world_named("reference-1").drawn(7), PolicyContract(), 4.0, 7)
    StatePublisher(bus, body, "robot0").publish(None, replace(ACCOUNT, refused=(("old", 3),)), 0)
    status = pb.Status.FromString(bus.publishers["status"].said[0][0])
    assert dict(status.verdicts) == {"old": 3}
