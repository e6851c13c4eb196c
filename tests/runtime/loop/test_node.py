from dataclasses import dataclass, field

import pytest

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.arrays import Actions, QValues, RetinaBatch
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.errors import DecisionEndedError
from reflexarc_runtime.keyframe import Keyframe
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlet, Outlets
from reflexarc_runtime.loop.pacing.lockstep_pacer import LockstepPacer
from reflexarc_runtime.loop.pacing.pacer import Pacer
from reflexarc_runtime.loop.pacing.rate_pacer import RatePacer
from reflexarc_runtime.loop.tick_record import TickRecord
from reflexarc_runtime.messages.topics import RESET, STOP
from reflexarc_runtime.messages.wire import Message, protobuf_encoding
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import SMALL, ScriptedPolicy
from support.sensing import MS, retina_message


@dataclass
class Heard:
    """An outlet that remembers."""

    payloads: list[bytes] = field(default_factory=list)

    def put(self, payload: bytes, time_ns: int) -> None:
        self.payloads.append(payload)


@dataclass
class Kept:
    """A sink that remembers."""

    messages: list[Message] = field(default_factory=list)
    state: str = "on"

    def put(self, message: Message) -> None:
        self.messages.append(message)

    def put_tick(self, record: TickRecord) -> None:
        self.messages += record.messages()

    def put_keyframe(self, keyframe: Keyframe) -> None:
        at_ns = keyframe.received_ns
        self.messages.append(Message("robot0/keyframe", b"", "", b"", at_ns))


class FeedingClock(ManualClock):
    """Puts a retina into the inbox every time that it is slept on."""

    def __init__(self, inbox: Inbox, silent_from: int = 1000) -> None:
        super().__init__()
        self.inbox, self.count, self.silent_from = inbox, 0, silent_from

    def sleep_until_ns(self, deadline_ns: int) -> None:
        super().sleep_until_ns(deadline_ns)
        if self.count < self.silent_from:
            self.inbox.put(retina_message(self.count, deadline_ns - MS))
        self.count += 1


def node_of(pacer: Pacer, kept: Kept | None = None) -> tuple[Node, Outlets]:
    controller = Controller(ScriptedPolicy(), SMALL, RetinaSense(SMALL.retina), "hash")
    outlets = Outlets(Heard(), Heard(), Heard())
    return Node(controller, pacer, outlets, sink=kept), outlets


def test_it_ticks_commands_and_ends_with_a_safe_command():
    inbox = Inbox()
    node, outlets = node_of(RatePacer(50.0, FeedingClock(inbox), inbox))
    summary = node.run(max_ticks=10)
    commands = [pb.Command.FromString(p) for p in outlets.command.payloads]  # type: ignore[attr-defined]
    assert summary.verdicts == {"OK": 8, "RECOVERING": 2, "STOPPED": 1}
    assert [c.sequence for c in commands] == list(range(11))
    assert commands[-1].verdict == pb.STOPPED
    assert commands[-1].linear_mps == 0.0
    assert commands[5].lateral_mps == 1.0
    assert (summary.ticks, summary.skipped_slots) == (11, 0)
    assert abs(summary.rate_hz - 50.0) < 1e-9


@dataclass
class Ordered:
    """Outlets that remember together what came after what."""

    said: list[tuple[str, bytes]] = field(default_factory=list)

    def outlet(self, name: str) -> Outlet:
        return OrderedOutlet(name, self.said)


@dataclass
class OrderedOutlet:
    name: str
    said: list[tuple[str, bytes]]

    def put(self, payload: bytes, time_ns: int) -> None:
        self.said.append((self.name, payload))


@pytest.mark.parametrize("fails", [False, True])
def test_its_own_lease_is_given_back_after_the_last_command_whatever_ends_it(fails: bool):
    heard, inbox = Ordered(), Inbox()
    controller = Controller(ScriptedPolicy(), SMALL, RetinaSense(SMALL.retina), "hash")
    outlets = Outlets(heard.outlet("command"), Heard(), Heard(), heard.outlet("release"))
    node = Node(controller, RatePacer(50.0, FeedingClock(inbox), inbox), outlets)

    def end() -> bool:
        if len(heard.said) < 3:
            return False
        if fails:
            raise MemoryError("broken on purpose")
        return True

    if fails:
        with pytest.raises(MemoryError):
            node.run(end)
    else:
        node.run(end)
    assert [name for name, _ in heard.said] == ["command"] * 4 + ["release"]
    assert pb.Release.FromString(heard.said[-1][1]).own


def test_the_batch_is_recorded_before_the_tick_that_used_it():
    inbox, kept = Inbox(), Kept()
    node, _ = node_of(RatePacer(50.0, FeedingClock(inbox), inbox), kept)
    node.run(max_ticks=3)
    names = [message.key.rpartition("/")[2] for message in kept.messages]
    assert names == ["keyframe", *["retina", "tick", "command"] * 3, "stop", "tick", "command"]


def test_when_the_sender_falls_silent_the_body_is_stopped_and_told_why():
    inbox = Inbox()
    node, _ = node_of(RatePacer(50.0, FeedingClock(inbox, silent_from=5), inbox))
    verdicts = node.run(max_ticks=20).verdicts
    # 100 ms are five periods of 20 ms: the input of tick 5 came 1 ms early, so four more are OK.
    assert verdicts == {"OK": 3 + 4, "STALE_INPUT": 11, "RECOVERING": 2, "STOPPED": 1}


def test_status_comes_once_a_second():
    inbox = Inbox()
    node, outlets = node_of(RatePacer(50.0, FeedingClock(inbox), inbox))
    node.run(max_ticks=151)
    said = [pb.Status.FromString(p) for p in outlets.status.payloads]  # type: ignore[attr-defined]
    assert [s.ticks for s in said] == [51, 101, 151]
    assert all(abs(s.rate_hz - 50.0) < 1e-6 for s in said)
    assert said[-1].verdicts["OK"] == 149


@pytest.mark.parametrize("rate_hz", [0.25, 0.5, 1.0, 1.5, 3.0])
def test_a_status_says_the_rate_also_where_it_speaks_of_one_tick_alone(rate_hz: float):
    inbox = Inbox()
    node, outlets = node_of(RatePacer(rate_hz, FeedingClock(inbox), inbox))
    summary = node.run(max_ticks=9)
    said = [pb.Status.FromString(p) for p in outlets.status.payloads]  # type: ignore[attr-defined]
    assert len(said) >= 2
    assert [s.rate_hz for s in said] == pytest.approx([rate_hz] * len(said))
    assert summary.rate_hz == pytest.approx(rate_hz)


class SlowSink(Kept):
    """Takes 3 ms of its clock for each record."""

    def __init__(self, clock: ManualClock) -> None:
        super().__init__()
        self.clock = clock

    def put_tick(self, record: TickRecord) -> None:
        super().put_tick(record)
        self.clock.time_ns += 3 * MS


@pytest.mark.parametrize("ticks", [1, 2, 9])
def test_the_first_tick_has_no_record_before_it(ticks: int):
    inbox = Inbox()
    clock = FeedingClock(inbox)
    node, outlets = node_of(RatePacer(50.0, clock, inbox), SlowSink(clock))
    phases = node.run(max_ticks=ticks).phases
    assert "record" not in phases if ticks == 1 else phases["record"].count == ticks - 1
    if ticks > 1:
        assert phases["record"].octaves == (ticks - 1,)
        assert phases["record"].max_ns == 3 * MS
    told = [pb.Tick.FromString(p).timing.record_ns for p in outlets.tick.payloads]  # type: ignore[attr-defined]
    assert told == [0, *[3 * MS] * ticks]  # in a log as ever; with the last one, a stop


def test_lockstep_gives_the_same_bytes_however_long_the_inputs_wait():
    def ticks(received_ns: int) -> list[bytes]:
        inbox = Inbox()
        for i in range(20):
            inbox.put(retina_message(i, received_ns * i, value=i, source_ns=i * 20 * MS))
        node, outlets = node_of(LockstepPacer(inbox))
        node.run(max_ticks=20)
        return outlets.tick.payloads  # type: ignore[attr-defined,no-any-return]

    assert ticks(received_ns=1) == ticks(received_ns=12345)


def test_lateness_is_measured_against_the_deadline():
    inbox = Inbox()
    clock = ManualClock(oversleep_ns=3 * MS)
    node, _ = node_of(RatePacer(50.0, clock, inbox))
    summary = node.run(max_ticks=5)
    assert summary.lateness_max_ns == 3 * MS
    assert abs(summary.lateness_p50_ns - 3 * MS) <= 3 * MS / 64


class Breaking:
    """A watch that raises at the beginning of one tick, or in every tick from then on."""

    state = "off"

    def __init__(self, at: int, until: int) -> None:
        self.ticks, self.at, self.until = 0, at, until

    def begin(self, now_ns: int) -> None:
        self.ticks += 1
        if self.at <= self.ticks < self.until:
            raise KeyboardInterrupt

    def rest(self, now_ns: int) -> None:
        pass

    def let_pass(self, outlet: Outlet, command: bytes, time_ns: int, is_safe: bool) -> bool:
        outlet.put(command, time_ns)
        return True


@pytest.mark.parametrize("until", [6, 1000])
def test_whatever_is_raised_the_last_command_is_safe(until: int):
    inbox = Inbox()
    controller = Controller(ScriptedPolicy(), SMALL, RetinaSense(SMALL.retina), "hash")
    outlets = Outlets(Heard(), Heard(), Heard())
    pacer = RatePacer(50.0, FeedingClock(inbox), inbox)
    node = Node(controller, pacer, outlets, watch=Breaking(5, until))
    with pytest.raises(KeyboardInterrupt):
        node.run(max_ticks=10)
    commands = [pb.Command.FromString(p) for p in outlets.command.payloads]  # type: ignore[attr-defined]
    assert [c.sequence for c in commands] == list(range(5))
    assert commands[-2].verdict == pb.OK
    assert (commands[-1].verdict, commands[-1].linear_mps) == (pb.STOPPED, 0.0)


class EndedPolicy(ScriptedPolicy):
    """Is ended by a watchdog whenever it is asked for the fifth time."""

    def decide(self, retinas: RetinaBatch) -> tuple[QValues, Actions]:
        answer = super().decide(retinas)
        if len(self.given) == 5:
            raise DecisionEndedError
        return answer


def test_a_tick_whose_decision_was_ended_is_none_and_its_messages_wait():
    inbox, kept = Inbox(), Kept()
    controller = Controller(EndedPolicy(), SMALL, RetinaSense(SMALL.retina), "hash")
    outlets = Outlets(Heard(), Heard(), Heard())
    pacer = RatePacer(50.0, FeedingClock(inbox), inbox)
    node = Node(controller, pacer, outlets, sink=kept)
    summary = node.run(max_ticks=10)
    ticks = [pb.Tick.FromString(p).decision for p in outlets.tick.payloads]  # type: ignore[attr-defined]
    assert [tick.index for tick in ticks] == list(range(11))
    assert summary.skipped_slots == 1
    assert sum(tick.inputs for tick in ticks) == sum(
        message.key.endswith(("retina", "stop", "overrun")) for message in kept.messages
    )
    assert [tick.inputs for tick in ticks if tick.inputs > 1] == [3]
    assert sum(tick.verdict == pb.OVERRUN for tick in ticks) == 1


def test_what_is_recorded_says_whose_decision_was_ended_behind_what_that_tick_was_given():
    inbox, kept = Inbox(), Kept()
    controller = Controller(EndedPolicy(), SMALL, RetinaSense(SMALL.retina), "hash")
    pacer = RatePacer(50.0, FeedingClock(inbox), inbox)
    Node(controller, pacer, Outlets(Heard(), Heard(), Heard()), sink=kept).run(max_ticks=10)
    names = [message.key.rpartition("/")[2] for message in kept.messages]
    at = names.index("overrun")
    assert names[at - 2 : at + 3] == ["command", "retina", "overrun", "retina", "tick"]
    said = pb.Overrun.FromString(kept.messages[at].payload)
    assert said.ended_policy == "hash"
    times_ns = [message.received_ns for message in kept.messages]
    assert times_ns[at - 1] <= times_ns[at] <= times_ns[at + 1]


def test_a_robot_that_is_stopped_by_somebody_skips_no_slot():
    inbox = Inbox()
    clock = FeedingClock(inbox)
    for topic, at_ns in ((STOP, 90 * MS), (RESET, 410 * MS)):
        encoding = protobuf_encoding(topic.schema)
        message = Message(topic.key("robot0"), b"", encoding, b"", at_ns)
        clock.at_ns(at_ns, lambda message=message: inbox.put(message))  # type: ignore[misc]
    summary = node_of(RatePacer(50.0, clock, inbox))[0].run(max_ticks=40)
    assert summary.verdicts["STOPPED"] == 16 + 1
    assert summary.skipped_slots == 0
    assert summary.phases["lateness"].count == 40


def test_its_status_names_action_verdict_policy_pace_and_due_rate():
    inbox = Inbox()
    controller = Controller(ScriptedPolicy(), SMALL, RetinaSense(SMALL.retina), "hash")
    said = Heard()
    names = {"hash": "reflex-0/policy.onnx"}
    node = Node(
        controller,
        RatePacer(50.0, FeedingClock(inbox, silent_from=60), inbox),
        Outlets(Heard(), Heard(), said),
        policy_name=lambda policy_hash: names[policy_hash],
        pace="rate",
    )
    node.run(max_ticks=120)
    driving, standing = (pb.Status.FromString(payload) for payload in said.payloads)
    assert (driving.action, driving.verdict) == ("left", pb.OK)
    assert (standing.action, standing.verdict) == ("", pb.STALE_INPUT)  # the safe command
    assert (driving.policy, driving.pace) == ("reflex-0/policy.onnx", "rate")
    assert (driving.contract_rate_hz, driving.is_stand_in) == (50.0, False)
