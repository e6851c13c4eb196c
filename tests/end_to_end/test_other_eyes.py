"""A body beside a runtime of another eye, with real processes: never OK on another's picture."""

import signal
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.summary import summarise
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.eye import RetinaSpec, Shading
from reflexarc_runtime.contract.motion import sideways_actions
from reflexarc_runtime.messages.body_info import decode_body
from reflexarc_sim_bridge.body.body import rebuild
from support.policies import exported
from support.processes import Process, finished, said_line, started, wait_until
from support.witness import body, runtime, witness

FAR = PolicyContract()
NEAR = replace(
    PolicyContract(retina=RetinaSpec(range_m=1.5, shading=Shading.COLOUR)),
    actions=sideways_actions(0.5),
    rate_hz=25.0,
    max_input_age_s=0.2,
)


@pytest.fixture(scope="module")
def far(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("far") / "far.onnx"
    path.write_bytes(exported(FAR, seed=5))
    return path


@pytest.fixture(scope="module")
def near(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("near") / "near.onnx"
    path.write_bytes(exported(NEAR, seed=5))
    return path


@contextmanager
def meeting_body(port: int, cwd: Path) -> Iterator[Process]:
    """A body that builds its eye for the runtime that it meets."""
    with started("sim", "--port", port, "--json", cwd=cwd) as process:
        said_line(process, "waiting for a runtime")
        yield process


@contextmanager
def answering(port: int, *answers: bytes) -> Iterator[None]:
    """Strangers who answer whoever asks for the policy."""
    with ExitStack() as open_ones:
        for answer in answers:
            bus = open_ones.enter_context(Bus(BusConfig("robot0", port), time.monotonic_ns))
            bus.offer_policy(lambda said=answer: said)
        yield


@pytest.mark.long
def test_with_a_policy_of_its_own_a_body_keeps_its_eye_and_another_runtime_does_not_drive(
    far: Path, near: Path, port: int, tmp_path: Path
):
    with body(far, port, tmp_path) as process:
        with started("run", near, "--port", port, "--no-guard", "--ticks", 100, "--json") as loop:
            line = said_line(loop, "INVALID_INPUT")
            verdicts = finished(loop)["verdicts"]
        assert finished(process, signal.SIGINT)["distance_m"] == 0.0
    assert "range_m 5 instead of 1.5" in line
    assert "shading nearness instead of colour" in line
    assert "OK" not in verdicts
    assert verdicts["INVALID_INPUT"] > 20


def test_under_another_runtime_a_body_builds_its_eye_anew_where_it_is(
    far: Path, near: Path, port: int, tmp_path: Path
):
    logs = [tmp_path / "far.mcap", tmp_path / "near.mcap"]
    with meeting_body(port, tmp_path) as process, witness(port) as seen:
        for policy, log in zip((far, near), logs, strict=True):
            before = seen.x_m[-1] if seen.x_m else 0.0
            with runtime(policy, port, tmp_path, "--record", log) as loop:
                seen.wait_for(lambda lease: lease.state == "driving", "a drive")
                wait_until(lambda at=before: seen.x_m[-1] > at + 0.5, "a way", 30.0)
                finished(loop, signal.SIGINT)
            seen.wait_for(lambda lease: not lease.holder, "a free body")
        way_m, steps = seen.x_m[-1], zip(seen.x_m, seen.x_m[1:], strict=False)
        assert all(0.0 <= after - before < 0.3 for before, after in steps)  # no jump
        end = finished(process, signal.SIGINT)
    assert end["distance_m"] == pytest.approx(way_m, abs=0.05)
    for log, contract in zip(logs, (FAR, NEAR), strict=True):
        assert replay(log).exit_status == 0
        assert_right_about_the_body(log, contract)


def assert_right_about_the_body(log: Path, contract: PolicyContract) -> None:
    """A recorded log tells of the body that its runtime drove: limits, rate, eye."""
    summary = summarise(log)
    info = summary.body
    assert info is not None
    rebuilt = rebuild(info, contract)
    assert info == rebuilt.info
    said = [decode_body(record.payload) for record in read_log(log).records("/robot0/body")]
    assert said[-1] == info


@pytest.mark.long
def test_whoever_answers_first_with_garbage_ends_no_body(far: Path, port: int, tmp_path: Path):
    racing = exported(replace(FAR, actions=sideways_actions(30.0)))
    with meeting_body(port, tmp_path) as process, answering(port, b"garbage", racing, b""):
        said = [said_line(process, "is no policy to build an eye for") for _ in range(3)]
        assert any("--max-speed-mps" in line for line in said)
        assert process.poll() is None
        with witness(port) as seen, runtime(far, port, tmp_path):
            seen.wait_for(lambda lease: lease.state == "driving", "a drive")
        finished(process, signal.SIGINT)


@pytest.mark.long
def test_a_body_that_was_built_for_a_stranger_is_built_anew_for_who_drives_it(
    far: Path, near: Path, port: int, tmp_path: Path
):
    with meeting_body(port, tmp_path) as process, answering(port, near.read_bytes()):
        said_line(process, "reference-1")
        with witness(port) as seen, runtime(far, port, tmp_path):
            assert "range_m=5 shading=nearness" in said_line(process, "built anew")
            seen.wait_for(lambda lease: lease.state == "driving", "a drive")
            begin_m = seen.x_m[-1]
            wait_until(lambda: seen.x_m[-1] > begin_m + 0.5, "a way", 30.0)
        finished(process, signal.SIGINT)


@pytest.mark.long
def test_of_two_runtimes_only_the_holder_s_contract_counts(
    far: Path, near: Path, port: int, tmp_path: Path
):
    with (
        meeting_body(port, tmp_path) as process,
        witness(port) as seen,
        runtime(far, port, tmp_path) as first,
    ):
        seen.wait_for(lambda lease: lease.state == "driving", "a drive")
        holder = seen.lease.holder
        with runtime(near, port, tmp_path) as second:
            seen.wait_for(lambda lease: lease.refused["another one holds the lease"] > 50, "two")
            assert seen.lease.holder == holder
            assert finished(first, signal.SIGINT)["verdicts"].get("INVALID_INPUT", 0) == 0
            seen.wait_for(
                lambda lease: lease.holder not in (b"", holder) and lease.state == "driving",
                "a drive of the other one",
            )
            assert seen.last_command is not None
            assert abs(seen.last_command.linear_mps) <= 0.5
            assert finished(second, signal.SIGINT)["verdicts"]["OK"] > 0
        finished(process, signal.SIGINT)
        assert process.returncode == 0
