"""A body beside a runtime of another eye: never OK. All of it real but for the bus."""

from typing import Any

import pytest

from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Decision, Verdict
from reflexarc_runtime.messages.topics import RETINA
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.sensing.senses import sense_for
from reflexarc_sim_bridge.body.body import Body
from reflexarc_sim_bridge.body.bridge import StatePublisher
from reflexarc_sim_bridge.body.gate.gate import Account
from reflexarc_sim_bridge.body.gate.lease import Lease
from reflexarc_sim_bridge.worlds.files import world_named
from support.eye_pairs import FIELDS, NOT_OF_THE_EYE, Pair, pairs
from support.policies import ScriptedPolicy

TICK_NS = 20_000_000
TICKS = 6
ACCOUNT = Account(Lease(), armed=True, stopped="", state="waiting for a command")


class OneTopic:
    """A bus of which only one topic is heard."""

    sender = bytes(16)

    def __init__(self) -> None:
        self.retinas: list[bytes] = []

    def publisher(self, topic: Any) -> "OneTopic":
        return self if topic is RETINA else OneTopic()

    def put(self, payload: bytes, time_ns: int) -> None:
        self.retinas.append(payload)


def retinas_of(pair: Pair) -> list[bytes]:
    """What the body of a pair publishes while it stands."""
    bus: Any = OneTopic()
    body = Body(world_named("reference-1").drawn(0), pair.body, 50.0, 0)
    state = StatePublisher(bus, body, "robot0")
    for tick in range(TICKS):
        state.publish(None, ACCOUNT, tick * TICK_NS)
    retinas: list[bytes] = bus.retinas
    return retinas


def decisions(pair: Pair) -> list[Decision]:
    """What the runtime of a pair makes of what its body publishes."""
    sense = sense_for("retina", pair.runtime.retina)
    controller = Controller(ScriptedPolicy(), pair.runtime, sense)
    state, made = State(), []
    encoding = protobuf_encoding(RETINA.schema)
    for tick, payload in enumerate(retinas_of(pair)):
        now_ns = tick * TICK_NS
        stamp = pack_stamp(Stamp(tick, now_ns, b"b" * 16))
        message = Message("robot0/retina", payload, encoding, stamp, now_ns)
        state, decision = controller.step(state, Inputs((message,), tick), now_ns)
        made.append(decision)
    return made


@pytest.mark.parametrize("seed", range(4))
def test_fifty_pairs_that_differ_in_one_field_of_the_eye_are_never_ok(seed: int):
    for pair in pairs(seed, 54):
        made = decisions(pair)
        assert {one.verdict for one in made} == {Verdict.INVALID_INPUT}, pair
        assert all(one.command.is_safe for one in made)
        if pair.field not in ("rays", "eyes", "channels"):  # those have another size as well
            assert pair.field in made[-1].reason


def test_fifty_pairs_that_differ_in_nothing_of_the_eye_are_ok():
    for pair in pairs(9, 48, NOT_OF_THE_EYE):
        assert decisions(pair)[-1].verdict is Verdict.OK, pair


def test_the_pairs_differ_in_what_they_say_and_in_nothing_else():
    for pair in pairs(1, 90):
        one, other = vars(pair.body.retina), vars(pair.runtime.retina)
        assert [name for name in one if one[name] != other[name]] == [pair.field]
    assert len(FIELDS) == 9
