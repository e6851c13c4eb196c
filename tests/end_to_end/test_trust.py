"""Who moves a robot: strangers, second runtimes and operators against real processes."""

import signal
import time
from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.topics import COMMAND, LEASE, STOP
from reflexarc_runtime.messages.wire import Message, protobuf_encoding, unpack_stamp
from support.policies import exported
from support.processes import finished, reflexarc, said_line, started, wait_until
from support.witness import FOR_EVER, ahead, body, joined, runtime, tell, witness


def test_an_anonymous_command_for_ever_moves_nothing_once_or_500_times_a_second(
    policy: Path, port: int, tmp_path: Path
):
    with body(policy, port, tmp_path) as process, witness(port) as stranger:
        publisher = stranger.publisher(COMMAND)
        encoding = protobuf_encoding(COMMAND.schema)
        publisher.put_raw(ahead(**FOR_EVER), b"", encoding)  # no attachment
        publisher.put(ahead(**FOR_EVER), 0)  # a sender, and no body
        assert stranger.rolled_m() == 0.0
        for _ in range(500):
            publisher.put(ahead(**FOR_EVER), 0)
            time.sleep(0.002)
        assert stranger.rolled_m() == 0.0
        # A bus that is in a hurry drops some of the 502.
        stranger.wait_for(lambda lease: sum(lease.refused.values()) > 250, "refusals")
        assert not stranger.lease.holder
        assert finished(process, signal.SIGINT)["distance_m"] == 0.0


def test_a_stranger_500_times_a_second_changes_nothing_of_a_drive(
    policy: Path, port: int, tmp_path: Path
):
    with (
        body(policy, port, tmp_path),
        witness(port) as stranger,
        runtime(policy, port, tmp_path, "--record", tmp_path / "drive.mcap") as loop,
    ):
        stranger.wait_for(lambda lease: lease.state == "driving", "a drive")
        holder, epoch = stranger.lease.holder, stranger.lease.epoch
        publisher, begin_m = stranger.publisher(COMMAND), stranger.x_m[-1]
        for _ in range(500):  # all that a stranger can know: who the body is, and what it said last
            assert stranger.retina is not None
            stamp = unpack_stamp(stranger.retina.attachment)
            fields = {"source_time_ns": stamp.time_ns, "valid_for_ns": 10**9, "body": stamp.sender}
            back = pb.Command(verdict=pb.OK, linear_mps=-1.0, source_sequence=0, **fields)
            publisher.put(back.SerializeToString(), 0)
            time.sleep(0.002)
        assert stranger.x_m[-1] - begin_m > 0.7
        assert min(b - a for a, b in zip(stranger.x_m, stranger.x_m[1:], strict=False)) >= 0.0
        assert (stranger.lease.holder, stranger.lease.epoch) == (holder, epoch)
        stranger.wait_for(
            lambda lease: lease.refused["another one holds the lease"] > 100, "refusals"
        )
        finished(loop, signal.SIGINT)
    assert replay(tmp_path / "drive.mcap").exit_status == 0


def test_a_command_in_plain_text_is_refused(policy: Path, port: int, tmp_path: Path):
    with body(policy, port, tmp_path), witness(port) as stranger:
        wait_until(lambda: stranger.retina is not None, "a retina")
        assert stranger.retina is not None
        stamp = unpack_stamp(stranger.retina.attachment)
        plain, proper = stranger.publisher(COMMAND, "text/plain"), stranger.publisher(COMMAND)
        now_ns = time.monotonic_ns()
        good = ahead(source_time_ns=now_ns, valid_for_ns=10**9, body=stamp.sender)
        plain.put(good, now_ns)
        assert stranger.rolled_m(0.2) == 0.0
        proper.put(good, now_ns)
        stranger.wait_for(lambda lease: lease.epoch == 1, "a lease for the same in order")


def test_of_two_runtimes_one_drives_and_after_its_death_the_other(
    policy: Path, port: int, tmp_path: Path
):
    with (
        body(policy, port, tmp_path),
        witness(port) as seen,
        runtime(policy, port, tmp_path) as first,
    ):
        seen.wait_for(lambda lease: lease.state == "driving", "a drive")
        holder = seen.lease.holder
        with runtime(policy, port, tmp_path):
            seen.wait_for(lambda lease: lease.refused["another one holds the lease"] > 50, "two")
            assert (seen.lease.holder, seen.lease.epoch) == (holder, 1)
            first.kill()
            killed_s = time.monotonic()
            seen.wait_for(lambda lease: lease.epoch == 2 and bool(lease.holder), "another holder")
            # 100 ms of silence, a step of each loop, and a poll of this test.
            assert time.monotonic() - killed_s < 1.0
            assert seen.lease.holder != holder
            assert seen.rolled_m() > 0.3


def test_a_release_hands_over(policy: Path, port: int, tmp_path: Path):
    with (
        body(policy, port, tmp_path),
        witness(port) as seen,
        runtime(policy, port, tmp_path),
        runtime(policy, port, tmp_path),
    ):
        seen.wait_for(
            lambda lease: lease.refused["another one holds the lease"] > 20, "two runtimes"
        )
        holder = seen.lease.holder
        assert tell(port, "release")[0] == 0
        seen.wait_for(lambda lease: lease.holder not in (b"", holder), "the other one")
        assert seen.rolled_m() > 0.3


@pytest.mark.long
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGHUP])
def test_a_runtime_that_ends_gives_its_lease_back_and_the_next_one_need_not_wait(
    port: int, tmp_path: Path, number: signal.Signals
):
    patient = tmp_path / "patient.onnx"  # without a release the lease would hold for 2 s more
    patient.write_bytes(exported(PolicyContract(max_input_age_s=2.0), seed=5))
    with (
        body(patient, port, tmp_path),
        witness(port) as seen,
        runtime(patient, port, tmp_path) as first,
    ):
        heard = list[tuple[bytes, int]]()
        seen.bus.subscribe([LEASE], lambda m: heard.append(holder_and_time(m)))
        seen.wait_for(lambda lease: lease.state == "driving", "a drive")
        holder = seen.lease.holder
        with runtime(patient, port, tmp_path) as second:
            seen.wait_for(lambda lease: lease.refused["another one holds the lease"] > 50, "two")
            finished(second, signal.SIGTERM)  # it holds nothing, and takes nothing away
            assert seen.rolled_m() > 0.3
            assert (seen.lease.holder, seen.lease.epoch) == (holder, 1)
        with runtime(patient, port, tmp_path):
            wait_until(lambda: seen.lease.refused["another one holds the lease"] > 100, "two")
            finished(first, number)
            seen.wait_for(lambda lease: lease.holder not in (b"", holder), "the next one")
    last_ns = max(time_ns for who, time_ns in heard if who == holder)
    next_ns = min(time_ns for who, time_ns in heard if who not in (b"", holder))
    assert 0 < next_ns - last_ns < 2_000_000_000


def holder_and_time(message: Message) -> tuple[bytes, int]:
    """Who held the lease when, on the body's own clock."""
    stamp = unpack_stamp(message.attachment)
    return pb.Lease.FromString(message.payload).holder, stamp.time_ns


def test_a_disarmed_body_stands_until_it_is_armed_and_after_a_reset_again(
    policy: Path, port: int, tmp_path: Path
):
    with (
        body(policy, port, tmp_path, "--no-auto-arm"),
        witness(port) as seen,
        runtime(policy, port, tmp_path, "--record", tmp_path / "drive.mcap") as loop,
    ):
        seen.wait_for(lambda lease: bool(lease.holder and lease.refused), "a runtime that waits")
        assert seen.rolled_m() == 0.0
        status, said = tell(port, "arm")
        assert (status, said["armed"]) == (0, True)
        assert seen.rolled_m() > 0.3
        status, said = tell(port, "stop", "--reason", "someone in the hall")
        assert (status, said["stopped"]) == (0, "someone in the hall")
        assert seen.rolled_m() == 0.0
        status, said = tell(port, "arm", "--patience", 1)
        assert status == 1
        assert "stopped (someone in the hall)" in said["complaint"]
        assert (tell(port, "reset")[0], seen.rolled_m()) == (0, 0.0)
        assert tell(port, "arm")[0] == 0
        assert seen.rolled_m() > 0.3
        finished(loop, signal.SIGINT)
    log = read_log(tmp_path / "drive.mcap")
    reasons = {tick.decision.reason for tick in log.ticks()}
    assert "someone in the hall" in reasons  # the runtime heard it, too
    assert replay(tmp_path / "drive.mcap").exit_status == 0


def test_a_stop_outlives_the_body(policy: Path, port: int, tmp_path: Path):
    with body(policy, port, tmp_path) as process, witness(port):
        assert tell(port, "stop")[0] == 0
        process.kill()
    words = ("sim", "--policy", policy, "--port", port, "--json")
    with started(*words, cwd=tmp_path) as process:
        said_line(process, "stopped (reflexarc stop) until `reflexarc reset`")
        with witness(port) as seen, runtime(policy, port, tmp_path):
            seen.wait_for(
                lambda lease: bool(lease.holder and lease.refused), "a runtime that waits"
            )
            assert seen.rolled_m() == 0.0
            assert tell(port, "reset")[0] == 0
            wait_until(lambda: seen.rolled_m(0.2) > 0.05, "a drive", 20.0)
    assert not [*(tmp_path / "runs").iterdir()]


def test_garbage_on_the_key_of_the_stop_stops(policy: Path, port: int, tmp_path: Path):
    with (
        body(policy, port, tmp_path),
        witness(port) as seen,
        runtime(policy, port, tmp_path),
    ):
        seen.wait_for(lambda lease: lease.state == "driving", "a drive")
        seen.publisher(STOP).put_raw(b"\xff\xff", b"", "text/plain")
        seen.wait_for(lambda lease: bool(lease.stopped), "a stop")
        assert seen.rolled_m() == 0.0


def test_beside_a_second_body_of_its_name_a_robot_stands(policy: Path, port: int, tmp_path: Path):
    with (
        body(policy, port, tmp_path),
        witness(port) as seen,
        runtime(policy, port, tmp_path),
    ):
        seen.wait_for(lambda lease: lease.state == "driving", "a drive")
        with body(policy, port, tmp_path, "--zenoh", joined(port, tmp_path)) as second:
            wait_until(lambda: seen.rolled_m(0.3) == 0.0, "standstill", 20.0)
            second.kill()
        wait_until(lambda: seen.rolled_m(0.2) > 0.1, "a drive", 20.0)


def test_a_log_that_is_played_onto_a_live_robot_moves_nothing(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    with body(policy, port, tmp_path), witness(port) as seen:
        with runtime(policy, port, tmp_path, "--record", log) as loop:
            seen.wait_for(lambda lease: lease.state == "driving", "a drive")
            time.sleep(3.0)
            finished(loop, signal.SIGINT)
        taken = reflexarc("play", log, "--port", port)
        assert taken.returncode == 2
        assert "cannot be listened on" in taken.stderr
        with runtime(policy, port, tmp_path):
            seen.wait_for(lambda lease: lease.state == "driving", "a drive")
            with started("play", log, "--zenoh", joined(port, tmp_path), "--json"):
                wait_until(lambda: seen.rolled_m(0.3) == 0.0, "standstill", 20.0)


def test_a_body_keeps_the_limits_of_its_world(policy: Path, port: int, tmp_path: Path):
    world = tmp_path / "reference-1-slow.toml"
    world.write_text('name = "reference-1 slow"\n[limits]\nlinear_mps = 0.25\n')
    with (
        body(policy, port, tmp_path, "--world", world),
        witness(port) as seen,
        runtime(policy, port, tmp_path),
    ):
        seen.wait_for(lambda lease: lease.refused["too fast: slowed down"] > 10, "slowed commands")
        begin_m, begin_s = seen.x_m[-1], time.monotonic()
        time.sleep(1.0)
        mean_mps = (seen.x_m[-1] - begin_m) / (time.monotonic() - begin_s)
        assert 0.1 < mean_mps < 0.27


def test_a_stop_in_lockstep_holds_and_the_drive_goes_on(policy: Path, port: int, tmp_path: Path):
    log = tmp_path / "drive.mcap"
    common = ("--port", port, "--lockstep", "--json")
    with (
        started("run", policy, "--no-guard", "--record", log, *common, cwd=tmp_path) as loop,
        started("sim", "--policy", policy, *common, cwd=tmp_path) as process,
        witness(port) as seen,
    ):
        seen.wait_for(lambda lease: lease.state == "driving", "a drive")
        assert tell(port, "stop")[0] == 0
        assert seen.rolled_m() == 0.0
        assert tell(port, "reset", "--patience", 30)[0] == 0  # a busy machine takes its time
        wait_until(lambda: seen.rolled_m(0.2) > 0.0, "a drive", 20.0)
        steps = finished(process, signal.SIGINT)["steps"]
        finished(loop, signal.SIGINT)
    assert replay(log).exit_status == 0
    assert len([*read_log(log).ticks()]) == steps + 1  # a stop makes no tick of its own


@pytest.mark.parametrize("command", ["arm", "stop", "reset", "release"])
def test_what_nobody_answers_ends_with_1_and_one_line(port: int, command: str):
    done = reflexarc(command, "--port", port, "--patience", 0.5)
    assert done.returncode == 1
    assert done.stderr == (
        f"reflexarc {command}: no body of robot0 answered within 0.5 s; nobody answers at "
        f"tcp/127.0.0.1:{port} (is the body started? another --port?)\n"
    )
