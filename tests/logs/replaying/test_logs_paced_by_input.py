"""A log of a loop that was paced by its inputs replays like any other."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from random import Random

import pytest

from reflexarc_logs.checking.check import check
from reflexarc_logs.container.run_info import RunInfo
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.summary import summarise
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.loop.clock import ManualClock
from reflexarc_runtime.loop.inbox import Inbox
from reflexarc_runtime.loop.node import Node
from reflexarc_runtime.loop.outlets import Outlets
from reflexarc_runtime.loop.pacing.input_pacer import InputPacer
from reflexarc_runtime.messages.topics import OVERRUN, RESET, RETINA, STATUS, STOP, Topic
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.policy.policy import load_policy
from reflexarc_runtime.sensing.senses import sense_for
from support.policies import exported
from support.recordings import Nowhere
from support.sensing import MS, retina_message

P = 20 * MS
START_NS = 5_000 * MS
CONTRACT = PolicyContract(retina=RetinaSpec(rays=16), hold_s=0.06)
CONTROLS = {
    STOP: pb.Stop(reason="somebody is in the hall"),
    RESET: pb.Reset(),
    OVERRUN: pb.Overrun(since_ns=1, late_ns=2),
}


class TwoSpeedClock(ManualClock):
    """Oversleeps now and then, and seldom by several periods."""

    def __init__(self, seed: int) -> None:
        super().__init__(START_NS)
        self._random = Random(seed)

    def sleep_until_ns(self, deadline_ns: int) -> None:
        self.oversleep_ns = self._random.choice([0, 0, 0, MS, 13 * MS, 70 * MS])
        super().sleep_until_ns(deadline_ns)


def record(path: Path, seed: int, ticks: int) -> Counter[str]:
    """A drive with inputs at odd times, silences, stops, resets and overruns."""
    random, clock, inbox = Random(seed), TwoSpeedClock(seed), Inbox()
    at_ns = START_NS
    for number in range(ticks):
        at_ns += random.choice([P, P, P - 1, 3 * MS, 14 * MS, 31 * MS, 8 * P])
        message = retina_message(number, at_ns, value=random.randrange(256), spec=CONTRACT.retina)
        clock.at_ns(at_ns, lambda message=message: inbox.put(message))  # type: ignore[misc]
        if random.random() < 0.1:
            topic = random.choice([STOP, RESET, RESET, OVERRUN])
            payload, encoding = CONTROLS[topic].SerializeToString(), protobuf_encoding(topic.schema)
            control = Message(topic.key("robot0"), payload, encoding, b"", at_ns)
            clock.at_ns(at_ns, lambda message=control: inbox.put(message))  # type: ignore[misc]
    policy = load_policy(exported(CONTRACT, seed))
    controller = Controller(
        policy, CONTRACT, sense_for("retina", CONTRACT.retina), policy.policy_hash
    )
    run = RunInfo(run_id=f"{seed:032x}", rate_hz=50.0, pace="input")
    with Recorder(path, run, policy.data, {}, wall_offset_ns=0) as recorder:
        pacer = InputPacer(50.0, clock, inbox, RETINA)
        outlets = Outlets(Nowhere(), Nowhere(), Nowhere())
        return Counter(
            Node(controller, pacer, outlets, sink=recorder).run(max_ticks=ticks).verdicts
        )


def test_it_replays_at_both_levels_with_stops_silences_and_overruns(tmp_path: Path):
    seen: Counter[str] = Counter()
    for seed in range(4):
        path = tmp_path / f"{seed}.mcap"
        seen += record(path, seed, 250)
        assert read_log(path).run.pace == "input"
        for level in ("policy", "node"):
            report = replay(path, level=level)
            assert report.exit_status == 0, report
    assert {"OK", "STALE_INPUT", "STOPPED", "OVERRUN", "RECOVERING"} <= set(seen)


@dataclass
class Heard:
    """An outlet whose messages a recorder hears."""

    recorder: Recorder
    topic: Topic

    def put(self, payload: bytes, time_ns: int) -> None:
        key, encoding = self.topic.key("robot0"), protobuf_encoding(self.topic.schema)
        self.recorder.put(Message(key, payload, encoding, pack_stamp(Stamp(0, time_ns)), time_ns))


def steady(path: Path, period_ns: int, pace: str, said: str = "") -> list[str]:
    """What is found wrong with a drive whose sensor has a period of its own.

    Args:
        path: of the log.
        period_ns: of the sensor.
        pace: what the recorder knows of the loop.
        said: what the loop says of itself.
    """
    clock, inbox = ManualClock(START_NS), Inbox()
    for number in range(120):
        at_ns = START_NS + number * period_ns
        message = retina_message(number, at_ns, spec=CONTRACT.retina)
        clock.at_ns(at_ns, lambda message=message: inbox.put(message))  # type: ignore[misc]
    policy = load_policy(exported(CONTRACT))
    controller = Controller(
        policy, CONTRACT, sense_for("retina", CONTRACT.retina), policy.policy_hash
    )
    run = RunInfo(run_id="ab" * 16, rate_hz=50.0, pace=pace)
    with Recorder(path, run, policy.data, {}, wall_offset_ns=0) as recorder:
        pacer = InputPacer(50.0, clock, inbox, RETINA)
        outlets = Outlets(Nowhere(), Nowhere(), Heard(recorder, STATUS))
        Node(controller, pacer, outlets, sink=recorder, pace=said).run(max_ticks=100)
    return [f.words for f in check(path).findings]


SKIPPED = "deadlines of the loop were skipped"


def test_a_sensor_slower_than_the_rate_is_no_gap_of_a_loop_that_follows_it(tmp_path: Path):
    assert not any(SKIPPED in w for w in steady(tmp_path / "a.mcap", P + 2 * MS, "input"))
    assert any(SKIPPED in w for w in steady(tmp_path / "b.mcap", P + 2 * MS, "rate"))


@pytest.mark.parametrize("said", ["", "rate", "input", "lockstep", "at will"])
def test_a_recorder_that_knows_no_pace_has_it_from_what_the_loop_says(tmp_path: Path, said: str):
    """`reflexarc record` hears the bus, and knows nothing else."""
    path = tmp_path / "a.mcap"
    found = steady(path, P + 2 * MS, "", said)
    assert any(SKIPPED in w for w in found) == (said != "input")
    assert summarise(path).pace == ("" if said == "at will" else said)
    assert steady(tmp_path / "b.mcap", P + 2 * MS, "input", "rate") == []  # its own word counts
