"""Replay is no formality: a log that was recorded replays, and one bit of difference is found."""

from collections.abc import Callable
from dataclasses import replace
from functools import partialmethod
from pathlib import Path

import numpy as np
import pytest
from foxglove_schemas_protobuf.LaserScan_pb2 import LaserScan
from google.protobuf.descriptor_pb2 import DescriptorProto
from hypothesis import given, settings
from hypothesis import strategies as st

from reflexarc_logs.container.run_info import RUN as RUN_METADATA
from reflexarc_logs.container.writing import END
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.recording.recorder import Recorder
from reflexarc_logs.replaying.loop_events import loop_events
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import LogError, PolicyError, UsageError
from reflexarc_runtime.loop.trials.trial import Trial
from reflexarc_runtime.messages.wire import Message, Stamp, pack_stamp, protobuf_encoding
from reflexarc_runtime.messages_pb2 import Decision, Tick
from reflexarc_runtime.policy.model_file import policy_hash
from reflexarc_runtime.policy.policy import load_policy
from support.looping_policies import FOR_EVER, looping
from support.networks import with_honest_vectors, with_weights
from support.policies import FailingPolicy, exported
from support.recordings import (
    CONTRACT,
    FAULT_STALLS,
    KEY,
    MS,
    PERIOD_NS,
    RUN,
    START_NS,
    WALL_OFFSET_NS,
    drive,
    faults,
    nominal,
    retina_at,
)
from support.rewriting import edit_decision_schema, edit_decisions, flip_bit, rewrite


def test_a_recorded_run_replays_in_every_bit_at_both_levels(log_path):
    report = replay(log_path)
    policy, node = report.levels
    assert report.exit_status == 0
    assert (policy.level, policy.ticks, policy.compared, policy.identical) == ("policy", 61, 58, 58)
    assert (node.level, node.ticks, node.compared, node.identical) == ("node", 61, 61, 61)
    assert node.fields_compared == 61 * 26  # leaves of reflexarc.Decision
    assert (node.not_compared, node.flips, report.notes) == ((), (), ())


def test_faults_replay_as_they_happened(tmp_path):
    contract = replace(CONTRACT, retina=replace(CONTRACT.retina, frames=3))
    drive(tmp_path / "log.mcap", exported(contract, 3), faults(300), 300, stalls=FAULT_STALLS)
    assert replay(tmp_path / "log.mcap").exit_status == 0


def test_a_run_on_scans_replays(policy, tmp_path):
    def scan_at(slot: int) -> Message:
        received_ns = START_NS + slot * PERIOD_NS - 3 * MS
        ranges = np.abs(np.sin(np.arange(181) * 0.1 + slot)) * 6
        ranges[slot % 181 :: 40] = np.inf
        scan = LaserScan(start_angle=-1.5708, end_angle=1.5708, ranges=ranges.tolist())
        stamp = pack_stamp(Stamp(slot, received_ns))
        encoding = protobuf_encoding("foxglove.LaserScan")
        return Message("robot0/scan", scan.SerializeToString(), encoding, stamp, received_ns)

    schedule = {slot: [scan_at(slot)] for slot in range(1, 40)}
    verdicts = drive(tmp_path / "log.mcap", policy, schedule, 39, run=replace(RUN, input="scan"))
    report = replay(tmp_path / "log.mcap")
    assert verdicts["OK"] == 37
    assert report.exit_status == 0
    assert len(report.levels) == 2


def test_counts_decide_which_inputs_a_tick_had_and_not_their_place_or_time(
    log_path, policy, tmp_path
):
    log = read_log(log_path)
    inputs = [event for event in loop_events(log) if isinstance(event, Message)]
    encoding = protobuf_encoding("reflexarc.Tick")
    ticks = [
        Message("robot0/tick", r.payload, encoding, pack_stamp(Stamp(r.sequence, r.publish_ns)), 0)
        for r in log.records("/robot0/tick")
    ]
    path = tmp_path / "log.mcap"
    with Recorder(path, RUN, policy, {}, wall_offset_ns=WALL_OFFSET_NS) as recorder:
        for message in [*inputs, *ticks]:
            recorder.put(message)
    assert replay(path, level="node").exit_status == 0


def test_what_was_rejected_of_another_stream_is_no_input(policy, tmp_path):
    broken = Message("robot0/pose", b"\xff", "text/plain", b"", START_NS)
    drive(tmp_path / "log.mcap", policy, nominal(9), 9, before=[broken])
    assert replay(tmp_path / "log.mcap", level="node").exit_status == 0


def test_a_policy_that_fails_replays_its_fault(policy, tmp_path):
    broken = with_weights(policy, "b2", lambda b: b.fill(np.nan))
    loaded = replace(load_policy(policy), graph=load_policy(broken, verify=False).graph)
    verdicts = drive(tmp_path / "log.mcap", loaded, nominal(10), 10)
    assert verdicts["POLICY_FAULT"] == 8
    faulty = replace(load_policy(policy), graph=loaded.graph)
    assert replay(tmp_path / "log.mcap", policy=faulty).exit_status == 0
    assert replay(tmp_path / "log.mcap").exit_status == 1


message = st.builds(
    Message,
    key=st.just(KEY),
    payload=st.sampled_from(
        [retina_at(1, np.full((1, 16, 1), v, np.uint8)).payload for v in (0, 9)]
    )
    | st.binary(max_size=30),
    encoding=st.sampled_from([protobuf_encoding("foxglove.RawImage")] * 4 + ["text/plain"]),
    attachment=st.builds(
        lambda sequence, time_ns: pack_stamp(Stamp(sequence, time_ns)),
        st.integers(-1, 2**32),
        st.integers(-1, 2**63 - 1),
    )
    | st.just(b""),
    received_ns=st.integers(START_NS, START_NS + 400 * MS),
)


@settings(max_examples=25, deadline=None)
@given(schedule=st.dictionaries(st.integers(1, 20), st.lists(message, max_size=4), max_size=20))
def test_whatever_arrives_and_whenever_replay_decides_the_same(schedule, policy, tmp_path_factory):
    path = tmp_path_factory.mktemp("any") / "log.mcap"
    drive(path, policy, schedule, 20)
    report = replay(path, level="node")
    assert (report.exit_status, report.levels[0].compared) == (0, 21)


def sign_of_a_live_weight(policy: bytes) -> bytes:
    def negate(weights: np.ndarray) -> None:
        weights[np.unravel_index(np.abs(weights).argmax(), weights.shape)] *= -1

    return with_weights(policy, "w2", negate)


def test_the_sign_of_one_weight_is_found_even_where_every_hash_and_vector_fits(
    log_path, policy, tmp_path
):
    forged = with_honest_vectors(sign_of_a_live_weight(policy))
    load_policy(forged)  # it is a policy in good order

    def name_it(decision: Decision) -> None:
        decision.policy_hash = policy_hash(forged)

    path = rewrite(
        log_path,
        tmp_path / "log.mcap",
        edit_decisions(name_it),
        metadata={RUN_METADATA: {"policy_hash": policy_hash(forged)}},
        attachments={"policy.onnx": forged},
    )
    report = replay(path)
    assert report.exit_status == 1
    for level in report.levels:
        assert level.first is not None
        assert level.first.tick == 2  # the first at which the policy was asked
        assert level.first.path.startswith("q_values[")


def test_one_bit_of_a_recorded_retina_is_found_at_its_tick(log_path, tmp_path):
    def edit(topic: str, nth: int, payload: bytes) -> bytes:
        hit = topic == "/robot0/retina" and nth == 30
        return flip_bit(payload, payload.index(b"2\x10") + 7) if hit else payload

    report = replay(rewrite(log_path, tmp_path / "log.mcap", edit))
    policy, node = report.levels
    assert report.exit_status == 1
    assert policy.identical == policy.compared  # the tick still holds what it saw
    assert node.first is not None
    assert (node.first.tick, node.first.path) == (30, "retina[5]")
    assert node.identical == 60


def at_tick_40(change: Callable[[Decision], None]) -> Callable[[Decision], None]:
    def edit(decision: Decision) -> None:
        if decision.index == 40:
            change(decision)

    return edit


def next_float(decision: Decision) -> None:
    decision.q_values[1] = np.nextafter(np.float32(decision.q_values[1]), np.float32(9))


def test_one_bit_of_a_q_value_is_found_at_both_levels(log_path, tmp_path):
    path = rewrite(log_path, tmp_path / "log.mcap", edit_decisions(at_tick_40(next_float)))
    report = replay(path)
    assert report.exit_status == 1
    for level in report.levels:
        assert level.first is not None
        assert (level.first.tick, level.first.path) == (40, "q_values[1]")
        assert level.compared - level.identical == 1


EDITS: dict[str, Callable[[Decision], None]] = {
    "command.linear_mps": lambda d: setattr(d.command, "linear_mps", 1.5),
    "command.source_time_ns": lambda d: d.command.ClearField("source_time_ns"),
    "input": lambda d: d.ClearField("input"),
    "input.age_ns": lambda d: setattr(d.input, "age_ns", d.input.age_ns + 1),
    "verdict": lambda d: setattr(d, "verdict", 3),
    "reason": lambda d: setattr(d, "reason", "because"),
    "policy_hash": lambda d: setattr(d, "policy_hash", "0" * 64),
    "inputs": lambda d: setattr(d, "inputs", 7),
    "index": lambda d: setattr(d, "index", 1000),
    "q_values": lambda d: d.q_values.append(0.5),
    "retina": lambda d: setattr(d, "retina", d.retina + b"x"),
}


@pytest.mark.parametrize("path", EDITS)
def test_any_field_of_a_decision_that_was_changed_is_named(path, log_path, tmp_path):
    forged = rewrite(log_path, tmp_path / "log.mcap", edit_decisions(at_tick_40(EDITS[path])))
    (node,) = replay(forged, level="node").levels
    assert node.first is not None
    assert node.first.path == path


def test_timing_is_never_compared(log_path, tmp_path):
    def slower(topic: str, nth: int, payload: bytes) -> bytes:
        if not topic.endswith("/tick"):
            return payload
        tick = Tick.FromString(payload)
        tick.timing.wake_ns += 1_000_000
        return tick.SerializeToString()

    assert replay(rewrite(log_path, tmp_path / "log.mcap", slower)).exit_status == 0


def test_weights_changed_in_the_attachment_alone_cannot_be_compared(log_path, policy, tmp_path):
    forged = sign_of_a_live_weight(policy)
    path = rewrite(log_path, tmp_path / "log.mcap", attachments={"policy.onnx": forged})
    with pytest.raises(LogError, match="not the one that the log names"):
        replay(path)


def test_a_policy_that_does_not_reproduce_its_vectors_cannot_be_compared(
    log_path, policy, tmp_path
):
    forged = sign_of_a_live_weight(policy)
    path = rewrite(
        log_path,
        tmp_path / "log.mcap",
        metadata={RUN_METADATA: {"policy_hash": policy_hash(forged)}},
        attachments={"policy.onnx": forged},
    )
    with pytest.raises(PolicyError, match=r"log.mcap: attached policy: golden vectors") as caught:
        replay(path)
    assert "\n" not in str(caught.value)


def test_a_flipped_byte_in_the_file_cannot_be_compared(log_path, tmp_path):
    data = log_path.read_bytes()
    (tmp_path / "log.mcap").write_bytes(flip_bit(data, len(data) // 2))
    with pytest.raises(LogError, match="damaged"):
        replay(tmp_path / "log.mcap")


def test_a_log_without_a_policy_asks_for_one_and_takes_it(log_path, policy, tmp_path):
    path = rewrite(log_path, tmp_path / "log.mcap", attachments={"policy.onnx": None})
    with pytest.raises(LogError, match="no policy is attached; give one with --policy"):
        replay(path)
    (tmp_path / "policy.onnx").write_bytes(policy)
    assert replay(path, policy=tmp_path / "policy.onnx").exit_status == 0


def test_another_policy_is_compared_in_what_it_does_and_not_in_its_name(log_path):
    other = load_policy(exported(CONTRACT, seed=9))
    report = replay(log_path, policy=other)
    policy, node = report.levels
    assert report.exit_status == 1
    assert not report.same_policy
    assert node.identical == 3  # no policy was asked at the first two ticks and the last
    assert policy.flips == node.flips
    assert all(not flip.rounding for flip in node.flips)


def test_an_equal_policy_with_another_provenance_is_identical(log_path, policy):
    loaded = load_policy(policy)
    renamed = replace(loaded, policy_hash="1" * 64)
    report = replay(log_path, policy=renamed)
    assert (report.exit_status, report.same_policy) == (0, False)


@pytest.mark.parametrize("rays", [8, 32])
def test_a_policy_for_another_eye_cannot_be_compared(rays, log_path):
    other = exported(replace(CONTRACT, retina=RetinaSpec(rays=rays)))
    with pytest.raises(LogError, match="give a policy that fits"):
        replay(log_path, policy=load_policy(other))


def test_a_level_is_replayed_alone_when_asked_for(log_path):
    for level in ("policy", "node"):
        assert [found.level for found in replay(log_path, level=level).levels] == [level]


def test_a_level_that_does_not_exist_is_refused(log_path):
    with pytest.raises(UsageError, match="expected policy or node, got 'deep'"):
        replay(log_path, level="deep")


UNFIT = {
    "recorded by a listener": ({RUN_METADATA: {"recorded_by": "record"}}, None, "by a listener"),
    "with records dropped": ({END: {"dropped": "3"}}, None, "3 records or chunks are missing"),
    "without its sensor stream": ({}, "/robot0/retina", "no sensor stream"),
}


@pytest.mark.parametrize("case", UNFIT)
def test_a_log_that_is_none_of_a_loop_replays_at_level_policy_only(case, log_path, tmp_path):
    metadata, left_out, reason = UNFIT[case]
    path = rewrite(
        log_path,
        tmp_path / "log.mcap",
        lambda topic, nth, payload: None if topic == left_out else payload,
        metadata=metadata,
    )
    report = replay(path)
    assert report.exit_status == 0
    assert [level.level for level in report.levels] == ["policy"]
    assert reason in report.notes[0]
    with pytest.raises(LogError, match=rf"no replay at level node: .*{reason}"):
        replay(path, level="node")


def test_a_truncated_log_replays_as_far_as_it_goes(log_path, tmp_path):
    data = log_path.read_bytes()
    (tmp_path / "log.mcap").write_bytes(data[: len(data) * 2 // 3])
    with pytest.raises(LogError, match="truncated"):
        replay(tmp_path / "log.mcap")
    report = replay(read_log(tmp_path / "log.mcap", allow_truncated=True))
    assert report.exit_status == 0
    assert report.levels[1].compared > 20
    assert "truncated" in report.notes[0]


def test_a_field_that_the_log_did_not_know_yet_is_counted_and_not_compared(log_path, tmp_path):
    def forget(descriptor: DescriptorProto) -> None:
        kept = [field for field in descriptor.field if field.name != "reason"]
        del descriptor.field[:]
        descriptor.field.extend(kept)

    path = rewrite(
        log_path,
        tmp_path / "log.mcap",
        edit_decisions(lambda decision: decision.ClearField("reason")),
        schema=edit_decision_schema(forget),
    )
    node = replay(path).levels[1]
    assert (node.identical, node.compared) == (61, 61)
    assert node.not_compared == ("reason",)
    assert node.fields_compared == 61 * 25


def test_a_field_that_changed_its_type_is_counted_and_not_compared(log_path, tmp_path):
    def retype(descriptor: DescriptorProto) -> None:
        for field in descriptor.field:
            field.type = 12 if field.name == "reason" else field.type  # bytes, not string

    path = rewrite(log_path, tmp_path / "log.mcap", schema=edit_decision_schema(retype))
    assert replay(path).levels[1].not_compared == ("reason",)


def test_a_field_of_a_newer_reflexarc_is_counted_and_not_compared(log_path, tmp_path):
    def learn(descriptor: DescriptorProto) -> None:
        descriptor.field.add(name="mood", number=99, type=9, label=1)

    def feel(decision: Decision) -> None:
        decision.MergeFromString(b"\x9a\x06\x04good")

    path = rewrite(
        log_path,
        tmp_path / "log.mcap",
        edit_decisions(feel),
        schema=edit_decision_schema(learn),
    )
    node = replay(path).levels[1]
    assert (node.identical, node.not_compared) == (61, ("mood",))


@pytest.fixture(scope="module")
def onnxruntime_log(policy: bytes, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("onnxruntime") / "run.mcap"
    drive(path, policy, nominal(50), 50, run=replace(RUN, backend="onnxruntime"))
    return path


@pytest.mark.parametrize("backend", [None, "numpy", "onnxruntime"])
def test_a_log_of_onnxruntime_replays_within_its_tolerance_on_any_backend(backend, onnxruntime_log):
    report = replay(onnxruntime_log, backend=backend)
    assert report.exit_status == 0
    assert report.backend == backend or backend is None


def test_a_policy_that_hangs_hangs_no_replay(
    log_path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    path = tmp_path / "policy.onnx"
    path.write_bytes(looping(PolicyContract(), FOR_EVER))
    monkeypatch.setattr(Trial, "__init__", partialmethod(Trial.__init__, loading_s=0.5))
    with pytest.raises(PolicyError, match="it hangs"):
        replay(log_path, policy=path, backend="onnxruntime")


def test_a_rounding_error_is_excused_with_onnxruntime_and_nothing_larger(onnxruntime_log, tmp_path):
    def drift(decision: Decision) -> None:
        decision.q_values[1] += 1e-4

    near = rewrite(onnxruntime_log, tmp_path / "near.mcap", edit_decisions(at_tick_40(next_float)))
    far = rewrite(onnxruntime_log, tmp_path / "far.mcap", edit_decisions(at_tick_40(drift)))
    assert replay(near).exit_status == 0
    assert replay(far).exit_status == 1


@pytest.mark.parametrize(("backend", "status"), [("onnxruntime", 0), ("numpy", 1)])
def test_a_flip_between_equal_values_is_rounding_and_only_onnxruntime_may_round(
    backend, status, policy, tmp_path
):
    def twin(array: np.ndarray) -> None:
        array[:] = array[:1]

    tied = with_honest_vectors(with_weights(with_weights(policy, "w2", twin), "b2", twin))
    source = tmp_path / "tied.mcap"
    drive(source, tied, nominal(50), 50, run=replace(RUN, backend=backend))

    def choose_left(decision: Decision) -> None:
        left = CONTRACT.actions[1]
        decision.winner = decision.action = decision.command.action = 1
        decision.command.linear_mps = left.linear_mps
        decision.command.lateral_mps = left.lateral_mps

    lie = edit_decisions(at_tick_40(choose_left))

    def edit(topic: str, nth: int, payload: bytes) -> bytes | None:
        return None if topic.endswith("/command") else lie(topic, nth, payload)

    report = replay(rewrite(source, tmp_path / "log.mcap", edit))
    assert report.exit_status == status
    for level in report.levels:
        (flip,) = level.flips
        assert (flip.tick, flip.recorded, flip.replayed) == (40, 1, 0)
        assert flip.rounding


def test_a_failing_policy_is_a_verdict_and_not_an_error(policy, tmp_path):
    failing = replace(load_policy(policy), graph=_Failing())
    verdicts = drive(tmp_path / "log.mcap", failing, nominal(5), 5)
    assert verdicts["POLICY_FAULT"] == 3
    report = replay(tmp_path / "log.mcap", policy=failing)
    assert (report.exit_status, report.levels[0].compared) == (0, 0)


class _Failing(FailingPolicy):
    name = "numpy"
    run = FailingPolicy.decide
