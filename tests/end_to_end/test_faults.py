"""Faults on purpose, real processes: the body stops in time, the loop lives, the log replays."""

import signal
from pathlib import Path

import numpy as np
import pytest

from campaigns.faults import campaign, summary
from reflexarc_logs.container.rejected import Intake, accepted_message, rejected_message
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.controller import Controller
from reflexarc_runtime.controller_state import Inputs, State
from reflexarc_runtime.decision import Verdict
from reflexarc_runtime.messages.codec import encode_retina
from reflexarc_runtime.messages.topics import REJECTED
from reflexarc_runtime.messages.wire import Message, Stamp
from reflexarc_runtime.messages_pb2 import Rejected
from reflexarc_runtime.sensing.senses import RetinaSense
from reflexarc_sim_bridge.body.faults.faulty_stream import FaultyStream
from reflexarc_sim_bridge.body.faults.script import FaultScript, Malformation, Malformed
from support.fault_judge import MS, Poll, Worth, outages
from support.policies import ScriptedPolicy
from support.processes import finished, reflexarc, started, wait_for_records

CONTRACT = PolicyContract()
SAMPLE = range(10)
"""Ten consecutive seeds have every kind once."""

POLL_NS = 5 * MS


def looks(driving_until_ms: int, late_ms: int = 0, end_ms: int = 400) -> list[Poll]:
    """A look every 5 ms; the first one at which it no longer drives may be late."""
    polls = []
    for time_ms in range(0, end_ms, 5):
        if driving_until_ms < time_ms < driving_until_ms + 5 + late_ms:
            continue  # overslept
        late = late_ms if time_ms == driving_until_ms + 5 + late_ms else 0
        polls.append((time_ms * MS, late * MS, time_ms <= driving_until_ms))
    return polls


def inputs(until_ms: int, step_ms: int = 20) -> list[Worth]:
    return [(time_ms * MS, time_ms * MS) for time_ms in range(0, until_ms + 1, step_ms)]


def test_the_judge_measures_from_the_last_good_input_to_the_first_look_without_driving():
    (outage,) = outages(looks(driving_until_ms=130), inputs(until_ms=60))
    assert outage.to_safe_ns == 75 * MS
    assert not outage.is_late


def test_the_judge_finds_a_body_that_drives_on():
    (outage,) = outages(looks(driving_until_ms=300), inputs(until_ms=60))
    assert outage.to_safe_ns == 245 * MS
    assert outage.is_late
    assert not outage.is_the_machine_s


def test_the_judge_finds_a_body_that_never_stops():
    (outage,) = outages(looks(driving_until_ms=1000), inputs(until_ms=60))
    assert outage.is_late
    assert not outage.is_the_machine_s


def test_the_judge_tells_oversleeping_from_driving_on():
    overslept = outages(looks(driving_until_ms=150, late_ms=60), inputs(until_ms=60))[0]
    drove_on = outages(looks(driving_until_ms=210, late_ms=60), inputs(until_ms=60))[0]
    assert (overslept.is_late, overslept.is_the_machine_s) == (True, True)
    assert (drove_on.is_late, drove_on.is_the_machine_s) == (True, False)


def test_the_judge_takes_worthless_and_late_messages_for_what_they_are():
    worthless: list[Worth] = [(time_ms * MS, None) for time_ms in range(80, 400, 20)]
    late: list[Worth] = [(time_ms * MS, (time_ms - 200) * MS) for time_ms in range(80, 400, 20)]
    for others in (worthless, late):
        (outage,) = outages(looks(driving_until_ms=300), inputs(until_ms=60) + others)
        assert outage.last_good_ns == 60 * MS
        assert outage.is_late


def test_the_judge_says_what_stopped_the_body_and_when_the_runtime_told_it_to():
    heard = [(60 * MS, "OK"), (100 * MS, "STALE_INPUT"), (300 * MS, "OK")]
    stopped_by = {
        until_ms: outages(looks(until_ms), inputs(until_ms=60), heard)[0] for until_ms in (90, 130)
    }
    assert [stopped_by[ms].cause for ms in (90, 130)] == ["watchdog", "STALE_INPUT"]
    assert {outage.to_told_ns for outage in stopped_by.values()} == {40 * MS}


def test_the_judge_sees_no_outage_where_good_inputs_go_on():
    assert outages(looks(driving_until_ms=1000), inputs(until_ms=400, step_ms=100)) == []


@pytest.mark.parametrize("how", list(Malformation))
def test_what_a_log_keeps_of_a_malformed_message_is_refused_for_the_same_reason(how: Malformation):
    stream = FaultyStream(FaultScript((Malformed(0.0, 1.0, how),)))
    retina = encode_retina(np.zeros(CONTRACT.retina.shape, np.uint8), CONTRACT.retina, 5)
    (sent,) = stream.say(retina, 5)
    live = Message("robot0/retina", sent.payload, sent.encoding, sent.attachment, 7)
    assert reason(live) == reason(kept(live))


def kept(message: Message) -> Message:
    """The message as replay gets it back out of a log."""
    entry = Intake("robot0").sort(message)
    if entry.key == REJECTED.key("robot0"):
        return rejected_message(Rejected.FromString(entry.payload), entry.received_ns)
    schema, stamp = entry.kind.DESCRIPTOR.full_name, Stamp(entry.sequence, entry.sent_ns or 0)
    return accepted_message(entry.key, schema, entry.payload, stamp, entry.received_ns)


def reason(message: Message) -> str:
    controller = Controller(ScriptedPolicy(), CONTRACT, RetinaSense(CONTRACT.retina))
    decision = controller.step(State(), Inputs((message,), 0), 10)[1]
    assert decision.verdict is Verdict.INVALID_INPUT
    return decision.reason


@pytest.mark.long
def test_under_every_kind_of_fault_the_body_stops_in_time_and_the_log_replays(tmp_path: Path):
    report = summary(campaign(SAMPLE, tmp_path))
    assert report["failures"] == {}
    assert report["runs"] == report["all"]["replayed"] == len(SAMPLE) + 2
    assert report["all"]["stops"] > 5  # it drove, or stopping would be no art
    assert {"INVALID_INPUT", "STALE_INPUT", "RECOVERING", "OK"} <= set(report["all"]["verdicts"])


def test_a_simulated_body_sends_its_retinas_through_a_script(
    policy: Path, port: int, tmp_path: Path
):
    script, log = tmp_path / "faults.toml", tmp_path / "drive.mcap"
    script.write_text(
        'repeat_s = 1.0\n[[fault]]\nkind = "silence"\nbegin_s = 0.2\nduration_s = 0.3\n'
        '[[fault]]\nkind = "malformed"\nbegin_s = 0.7\nduration_s = 0.1\nhow = "truncated"\n'
    )
    with (
        started("sim", "--policy", policy, "--port", port, "--faults", script, "--json") as body,
        started("run", policy, "--no-guard", "--port", port, "--record", log, "--json") as runtime,
    ):
        wait_for_records(log, "pose", 150)
        said = finished(runtime, signal.SIGINT)
        finished(body, signal.SIGINT)
    assert {"OK", "STALE_INPUT", "INVALID_INPUT", "RECOVERING"} <= set(said["verdicts"])
    assert replay(log).exit_status == 0
    poses = [record.publish_ns for record in read_log(log).records("/robot0/pose")]
    assert len(poses) > sum(1 for _ in read_log(log).records("/robot0/retina"))


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--faults", "none.toml"], "cannot be read"),
        (["--faults", "seed:x"], "seed:N"),
        (["--faults", "seed:1", "--lockstep"], "--lockstep"),
    ],
)
def test_wrong_faults_are_said_in_one_line(tmp_path: Path, words: list[str], expected: str):
    done = reflexarc("sim", *words, cwd=tmp_path)
    assert done.returncode == 2
    assert expected in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
