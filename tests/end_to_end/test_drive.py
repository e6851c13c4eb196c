"""Body, runtime and recorder as real processes, in real time."""

import signal
from pathlib import Path

import pytest
from foxglove_schemas_protobuf.PoseInFrame_pb2 import PoseInFrame

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.guard_settings import GuardSettings
from reflexarc_runtime.messages_pb2 import Status, Tick
from reflexarc_runtime.policy.model_file import policy_hash
from support.processes import finished, reflexarc, said_line, started, wait_for_records


def ticks_of(path: Path) -> list[Tick]:
    return list(read_log(path).ticks())


def recording(path: Path) -> Log:
    return read_log(path.with_name(path.name + ".partial"), allow_truncated=True)


def asked(verdicts: dict[str, int]) -> int:
    """At how many ticks the policy was asked, whatever its guard made of the answer."""
    return sum(verdicts.get(name, 0) for name in ("OK", "GUARDED", "STUCK"))


def test_a_50_hz_loop_of_12_s_loses_neither_a_tick_nor_a_retina(
    policy: Path, port: int, tmp_path: Path
):
    log, heard = tmp_path / "drive.mcap", tmp_path / "heard.mcap"
    with (
        started("sim", "--policy", policy, "--port", port, "--json") as body,
        started("record", "-o", heard, "--port", port, "--json") as recorder,
    ):
        said_line(body, "reference-1")
        said_line(recorder, "reflexarc record:")
        words = ("run", policy, "--port", port, "--record", log, "--ticks", 600, "--json")
        with started(*words) as loop:
            summary = finished(loop)
        finished(body, signal.SIGINT)
        finished(recorder, signal.SIGINT)
    read = read_log(log)
    assert [tick.decision.index for tick in read.ticks()] == list(range(601))
    numbers = [record.sequence for record in read.records("/robot0/retina")]
    assert numbers == list(range(numbers[0], numbers[0] + len(numbers)))
    assert len(numbers) > 550
    assert summary["ticks"] == 601
    assert asked(summary["verdicts"]) > 550
    assert GuardSettings.from_json(read.run.guard) == GuardSettings()
    said = [status for _, status in read_log(heard).messages("/robot0/status", Status)]
    assert {status.guard for status in said if status.node == "runtime"} == {"on"}
    assert replay(log).exit_status == 0
    assert replay(heard, policy=policy, level="policy").exit_status == 0


@pytest.mark.long
@pytest.mark.parametrize("first", ["sim", "run", "record"])
def test_the_processes_find_each_other_in_any_order(
    policy: Path, port: int, tmp_path: Path, first: str
):
    log, heard = tmp_path / "drive.mcap", tmp_path / "heard.mcap"
    commands = {
        "sim": ("sim", "--port", port, "--json"),
        "run": ("run", policy, "--port", port, "--record", log, "--json"),
        "record": ("record", "-o", heard, "--port", port, "--json"),
    }
    words = [commands.pop(first), *commands.values()]
    with started(*words[0]) as a:
        said_line(a, f"reflexarc {first}:")
        with started(*words[1]) as b, started(*words[2]) as c:
            processes = dict(zip([first, *commands], [a, b, c], strict=True))
            wait_for_records(log, "retina", 100)
            wait_for_records(heard, "tick", 20)
            runtime = finished(processes["run"], signal.SIGTERM)
            finished(processes["record"], signal.SIGINT)
            finished(processes["sim"], signal.SIGINT)
    assert asked(runtime["verdicts"]) > 50
    assert runtime["verdicts"]["STOPPED"] == 1
    assert replay(log).exit_status == 0
    assert {r.topic for r in read_log(heard).records()} >= {"/robot0/retina", "/robot0/tick"}
    assert policy_hash(read_log(log).policy or b"") == policy_hash(policy.read_bytes())


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_in_a_safe_command_and_a_finished_log(
    policy: Path, port: int, tmp_path: Path, number: signal.Signals
):
    log = tmp_path / "drive.mcap"
    with (
        started("sim", "--policy", policy, "--port", port) as body,
        started("run", policy, "--port", port, "--record", log, "--json") as runtime,
    ):
        said_line(runtime, "reflexarc run:")
        said_line(body, "reference-1")
        wait_for_records(log, "retina", 20)
        finished(runtime, number)
    last = ticks_of(log)[-1].decision
    assert last.command.linear_mps == 0.0
    assert not last.command.HasField("source_time_ns")
    assert read_log(log).complete


def test_killed_in_the_middle_it_loses_at_most_the_last_second(
    policy: Path, port: int, tmp_path: Path
):
    log, saved = tmp_path / "drive.mcap", tmp_path / "saved.mcap"
    heard = tmp_path / "heard.mcap"
    with (
        started("sim", "--policy", policy, "--port", port),
        started("record", "-o", heard, "--port", port, "--json") as recorder,
    ):
        said_line(recorder, "reflexarc record:")
        with started("run", policy, "--port", port, "--record", log) as runtime:
            wait_for_records(log, "retina", 150)
            runtime.kill()
            runtime.wait()
        finished(recorder, signal.SIGINT)
    assert not log.exists()
    assert reflexarc("recover", f"{log}.partial", "-o", saved).returncode == 1  # its end is lost
    done, kept = ticks_of(heard)[-1].decision, ticks_of(saved)[-1].decision
    assert 0 <= done.now_ns - kept.now_ns <= 1_000_000_000
    report = replay(saved)
    assert report.exit_status == 0
    assert {level.level for level in report.levels} == {"policy", "node"}


def test_the_body_stops_by_itself_when_the_runtime_dies(policy: Path, port: int, tmp_path: Path):
    heard = tmp_path / "heard.mcap"
    with (
        started("sim", "--policy", policy, "--port", port),
        started("record", "-o", heard, "--port", port, "--json") as recorder,
    ):
        said_line(recorder, "reflexarc record:")
        with started("run", policy, "--port", port) as runtime:
            said_line(runtime, "reflexarc run:")
            wait_for_records(heard, "tick", 60)
            runtime.kill()
            runtime.wait()
        poses_until_now = sum(1 for _ in recording(heard).records("/robot0/pose"))
        wait_for_records(heard, "pose", poses_until_now + 50)
        finished(recorder, signal.SIGINT)
    log = read_log(heard)
    last_command_ns = max(r.log_ns for r in log.records("/robot0/command"))
    places = [
        pose.pose.position.x
        for record, pose in log.messages("/robot0/pose", PoseInFrame)
        if record.log_ns > last_command_ns + 150_000_000  # valid_for is 100 ms
    ]
    assert len(places) > 5
    assert len(set(places)) == 1
