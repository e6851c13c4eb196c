"""The real node, paced by its inputs on a clock that moves by itself."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from itertools import pairwise

from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.loop.cadence.monitor import Summary
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.input_pacer import InputPacer
from reflexarc_runtime.messages.topics import RETINA, STOP
from reflexarc_runtime.messages.wire import Message, protobuf_encoding
from reflexarc_runtime.sensing.senses import RetinaSense
from support.policies import SMALL, ScriptedPolicy
from support.sensing import MS, retina_message

P = 20 * MS
OLDEST = round(SMALL.max_input_age_s * 1e9)


@dataclass
class Taken:
    """An outlet that takes time on the loop's clock, and remembers when it was given what."""

    clock: ManualClock
    takes_ns: int = 0
    said: list[tuple[int, bytes]] = field(default_factory=list)

    def put(self, payload: bytes, time_ns: int) -> None:
        self.clock.advance_to_ns(self.clock.time_ns + self.takes_ns)
        self.said.append((self.clock.time_ns, payload))


@dataclass
class Drive:
    """What a loop said, and when."""

    commands: list[tuple[int, pb.Command]]
    ticks: list[pb.Tick]
    statuses: list[pb.Status]
    summary: Summary


def drive(
    arrivals: Mapping[int, Message], ticks: int, *, takes_ns: int = 0, leaves_out: bool = True
) -> Drive:
    """Run a loop with these arrivals, by their times."""
    clock, inbox = ManualClock(), Inbox()
    for at_ns, message in arrivals.items():
        clock.at_ns(at_ns, lambda message=message: inbox.put(message))  # type: ignore[misc]
    pacer = InputPacer(50.0, clock, inbox, RETINA, leaves_out=leaves_out)
    controller = Controller(ScriptedPolicy(), SMALL, RetinaSense(SMALL.retina), "hash")
    command, tick, status = Taken(clock, takes_ns), Taken(clock), Taken(clock)
    summary = Node(controller, pacer, Outlets(command, tick, status)).run(max_ticks=ticks)
    return Drive(
        [(at_ns, pb.Command.FromString(payload)) for at_ns, payload in command.said],
        [pb.Tick.FromString(payload) for _, payload in tick.said],
        [pb.Status.FromString(payload) for _, payload in status.said],
        summary,
    )


def retinas(times_ns: list[int]) -> dict[int, Message]:
    return {at_ns: retina_message(n, at_ns) for n, at_ns in enumerate(times_ns)}


def stop_at(at_ns: int) -> dict[int, Message]:
    payload = pb.Stop(reason="tests").SerializeToString()
    return {at_ns: Message("robot0/stop", payload, protobuf_encoding(STOP.schema), b"", at_ns)}


def test_a_command_leaves_at_the_moment_of_its_picture():
    driven = drive(retinas(list(range(P + 7 * MS, 50 * P, P))), 40)
    answered = [(at, command) for at, command in driven.commands if command.verdict == pb.OK]
    assert len(answered) == 38  # three good inputs in a row come first
    assert all(at == command.source_time_ns for at, command in answered)


def test_when_the_sensor_falls_silent_the_body_is_stopped_a_period_after_the_age_at_most():
    last_ns = 10 * P
    driven = drive(retinas(list(range(P, last_ns + 1, P))), 30)
    safe = [at for at, command in driven.commands if command.verdict == pb.STALE_INPUT]
    assert OLDEST < safe[0] - last_ns <= OLDEST + P
    assert [at - safe[0] for at in safe] == [n * P for n in range(len(safe))]


def test_a_stop_is_obeyed_at_once():
    at_ns = 10 * P + 13 * MS
    driven = drive(retinas(list(range(P, 20 * P, P))) | stop_at(at_ns), 15)
    stopped = [at for at, command in driven.commands if command.verdict == pb.STOPPED]
    assert stopped[0] == at_ns


def age_at_command(tick: pb.Tick) -> int:
    """By what the log holds: the age at the tick's time, and what deciding and sending took."""
    return int(tick.decision.input.age_ns + tick.timing.decide_ns + tick.timing.publish_ns)


def test_the_age_of_the_picture_is_counted_at_the_moment_of_the_command():
    driven = drive(retinas(list(range(P, 60 * P, P))), 50, takes_ns=3 * MS)
    assert [age_at_command(tick) for tick in driven.ticks[:-1]] == [3 * MS] * 50
    spread = driven.summary.phases["picture age"]
    assert spread.count == driven.summary.verdicts["OK"]
    assert spread.max_ns == 3 * MS
    assert driven.summary.phases["publish"].max_ns == 3 * MS


def test_a_picture_that_waited_on_its_way_is_as_old_as_it_is():
    arrivals = retinas(list(range(P, 10 * P, P)))
    late_ns = 10 * P
    arrivals[late_ns] = retina_message(99, late_ns, source_ns=late_ns - 15 * MS)
    ticks = drive(arrivals, 10).ticks
    assert age_at_command(ticks[9]) == 15 * MS


def test_without_a_picture_there_is_no_age():
    driven = drive({}, 5)
    assert "picture age" not in driven.summary.phases
    assert driven.summary.phases["lateness"].count == 5


def test_the_status_says_how_long_each_phase_took_in_the_last_second():
    driven = drive(retinas(list(range(P, 200 * P, P))), 160, takes_ns=3 * MS)
    assert len(driven.statuses) == 3
    for status in driven.statuses[1:]:
        phases = {phase.phase: phase for phase in status.phases}
        assert phases["picture age"].count == phases["lateness"].count == 50
        assert phases["publish"].max_ns == 3 * MS
        assert abs(phases["publish"].p50_ns - 3 * MS) <= 3 * MS / 64
        assert (phases["publish"].least_bits, list(phases["publish"].octaves)) == (22, [50])
        assert phases["lateness"].p999_ns == 0


times = st.lists(st.integers(1, 70 * MS), min_size=1, max_size=40).map(
    lambda gaps: [sum(gaps[: n + 1]) for n in range(len(gaps))]
)


@settings(max_examples=40, deadline=None)
@given(times, st.integers(0, 8 * MS), st.booleans(), st.none() | st.integers(1, 800 * MS))
def test_whatever_arrives_no_command_rests_on_an_old_picture_and_none_is_late(
    at_ns: list[int], takes_ns: int, leaves_out: bool, stop_ns: int | None
):
    arrivals = retinas(at_ns)
    if stop_ns is not None:
        arrivals |= stop_at(stop_ns)
    driven = drive(arrivals, 40, takes_ns=takes_ns, leaves_out=leaves_out)
    for tick in driven.ticks[:-1]:
        if tick.decision.command.HasField("source_time_ns"):
            assert tick.decision.input.age_ns <= OLDEST
            assert stop_ns is None or tick.decision.now_ns < stop_ns
            # phases are logged to the microsecond
            assert abs(age_at_command(tick) - tick.decision.input.age_ns - takes_ns) <= 1000
    slots = [tick.decision.slot for tick in driven.ticks[:-1]]
    assert slots == sorted(set(slots))
    sent = [at for at, _ in driven.commands[:-1]]
    assert all(b - a <= 2 * P for a, b in pairwise(sent))
    assert all(at >= n * P - P // 2 for n, at in enumerate(sent, 1))
