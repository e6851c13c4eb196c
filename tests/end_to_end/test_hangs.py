"""A loop that hangs, is late, or raises, in real processes: the body is told to stand."""

import json
import os
import pty
import resource
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from support.looping_policies import FOR_EVER, looping
from support.plain_body import SPECIAL, USUAL, PlainBody, plain_body
from support.processes import (
    PATIENCE_S,
    finished,
    reflexarc,
    said_line,
    started,
    wait_for_records,
    wait_until,
)

CONTRACT = PolicyContract()
DRIVEN = 20
"""Commands of a run that has really begun."""


def both_levels_agree(log: Path) -> bool:
    report = replay(log)
    return report.exit_status == 0 and {r.level for r in report.levels} == {"policy", "node"}


def harmed(fault: str, policy: Path, port: int, log: Path) -> subprocess.CompletedProcess[str]:
    """A runtime with a fault in its loop, to its end or to its 150th tick."""
    module = ("-m", "support.hanging_runtime", fault)
    words = ("run", policy, "--no-guard", "--port", port, "--record", log, "--ticks", 150, "--json")
    return subprocess.run(
        [sys.executable, *module, *map(str, words)],
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
        cwd=Path(__file__).parents[1],
    )


def saved(log: Path) -> Path:
    """What is left of a log whose process was ended."""
    assert not log.exists()
    whole = log.with_suffix(".saved.mcap")
    assert reflexarc("recover", f"{log}.partial", "-o", whole).returncode == 1  # its end is lost
    return whole


def drove(body: PlainBody) -> bool:
    return body.verdicts.count("OK") >= DRIVEN


def nothing_drives_between_overrun_and_recovering(verdicts: list[str]) -> bool:
    after = verdicts[verdicts.index("OVERRUN") :]
    return "OK" not in after or after.index("RECOVERING") < after.index("OK")


def test_a_loop_that_hangs_in_python_is_stopped_by_the_thread_and_ended_by_the_kernel(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    with plain_body(CONTRACT, port) as body:
        done = harmed("python", policy, port, log)
    assert done.returncode == -signal.SIGALRM
    assert "hanging_runtime.py" in done.stderr  # where it hung
    assert drove(body)
    assert (body.last.verdict, body.last.linear_mps) == (pb.OVERRUN, 0.0)
    assert not body.last.HasField("source_time_ns")
    assert nothing_drives_between_overrun_and_recovering(body.verdicts)
    assert len(body.overruns) == 1
    assert body.watchdogs[-1].startswith("the loop is late")
    assert both_levels_agree(saved(log))


def test_what_holds_the_interpreters_lock_is_ended_by_the_kernel(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    with plain_body(CONTRACT, port) as body:
        done = harmed("numpy", policy, port, log)
    assert done.returncode == -signal.SIGALRM
    assert "hanging_runtime.py" in done.stderr
    assert drove(body)
    # The bound on standstill is the body's own: how long it obeys a command.
    assert body.last.valid_for_ns <= CONTRACT.max_input_age_ns
    assert both_levels_agree(saved(log))


def test_a_slow_tick_is_a_verdict_and_what_it_decided_is_not_sent(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    with plain_body(CONTRACT, port) as body:
        done = harmed("slow", policy, port, log)
    assert done.returncode == 0, done.stderr
    assert nothing_drives_between_overrun_and_recovering(body.verdicts)
    assert body.verdicts[-2] == "OK"  # it went on
    assert [r.topic for r in read_log(log).records("/robot0/overrun")] == ["/robot0/overrun"]
    assert both_levels_agree(log)


def test_a_loop_that_raises_ends_in_a_safe_command_and_a_finished_log(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    with plain_body(CONTRACT, port) as body:
        done = harmed("escape", policy, port, log)
    assert done.returncode == 1
    assert "raised in the loop" in done.stderr
    assert drove(body)
    assert (body.last.verdict, body.last.linear_mps) == (pb.STOPPED, 0.0)
    assert read_log(log).complete
    assert not log.with_name(log.name + ".partial").exists()
    assert both_levels_agree(log)


def test_a_policy_that_never_returns_is_ended_and_the_loop_goes_on(port: int, tmp_path: Path):
    log, policy = tmp_path / "drive.mcap", tmp_path / "special.onnx"
    policy.write_bytes(looping(CONTRACT, FOR_EVER, at_intensity=SPECIAL))
    words = (
        "run",
        policy,
        "--no-guard",
        "--backend",
        "onnxruntime",
        "--port",
        port,
        "--record",
        log,
        "--json",
    )
    with plain_body(CONTRACT, port) as body, started(*words) as runtime:
        wait_until(lambda: drove(body), "a runtime that drives")
        body.intensity = SPECIAL
        wait_until(lambda: len(body.overruns) >= 2, "overruns")
        body.intensity = USUAL
        until_now = body.verdicts.count("OK")
        wait_until(lambda: body.verdicts.count("OK") > until_now + DRIVEN, "a loop that is back")
        summary = finished(runtime, signal.SIGTERM)
    assert summary["verdicts"]["OVERRUN"] >= 2
    assert nothing_drives_between_overrun_and_recovering(body.verdicts)
    assert body.last.verdict == pb.STOPPED
    assert both_levels_agree(log)


def test_a_policy_that_hangs_at_load_or_cannot_keep_its_period_is_refused(
    port: int, tmp_path: Path
):
    policy = tmp_path / "policy.onnx"
    words = ("run", policy, "--no-guard", "--backend", "onnxruntime", "--port", port, "--ticks", 3)
    for trips, complaint in ((FOR_EVER, "it hangs"), (60_000, "expected a decision within 20 ms")):
        policy.write_bytes(looping(CONTRACT, trips))
        done = reflexarc(*words)
        assert done.returncode == 2
        assert complaint in done.stderr
        assert len(done.stderr.splitlines()) == 1


def test_a_policy_that_hangs_hangs_no_body(port: int, tmp_path: Path):
    policy = tmp_path / "policy.onnx"
    policy.write_bytes(looping(CONTRACT, FOR_EVER))
    words = ("sim", "--policy", policy, "--port", port, "--steps", 3, "--json")
    done = reflexarc(*words, cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["steps"] == 3


def test_without_a_watchdog_the_status_says_so(policy: Path, port: int):
    words = ("run", policy, "--no-guard", "--port", port, "--ticks", 80, "--no-watchdog", "--json")
    with plain_body(CONTRACT, port) as body:
        assert reflexarc(*words).returncode == 0
    assert set(body.watchdogs) == {"off"}


@pytest.mark.parametrize("number", [signal.SIGHUP, signal.SIGQUIT])
def test_a_hang_up_and_a_quit_end_as_a_termination_does(
    policy: Path, port: int, tmp_path: Path, number: signal.Signals
):
    log = tmp_path / "drive.mcap"
    words = ("run", policy, "--no-guard", "--port", port, "--record", log, "--json")
    with plain_body(CONTRACT, port) as body, started(*words) as runtime:
        wait_until(lambda: drove(body), "a runtime that drives")
        finished(runtime, number)
    assert (body.last.verdict, body.last.linear_mps) == (pb.STOPPED, 0.0)
    assert read_log(log).complete
    assert not log.with_name(log.name + ".partial").exists()
    assert both_levels_agree(log)


def test_a_terminal_that_is_closed_leaves_a_finished_log(policy: Path, port: int, tmp_path: Path):
    log = tmp_path / "drive.mcap"
    words = [sys.executable, "-m", "reflexarc", "run", policy, "--port", port, "--record", log]
    with plain_body(CONTRACT, port) as body:
        child, terminal = pty.fork()
        if not child:
            os.execv(sys.executable, [str(word) for word in words])
        wait_until(lambda: drove(body), "a runtime that drives")
        os.close(terminal)
        _, status = os.waitpid(child, 0)
    assert os.waitstatus_to_exitcode(status) == 0
    assert body.last.verdict == pb.STOPPED
    assert read_log(log).complete


def test_under_nohup_a_hang_up_ends_nothing(policy: Path, port: int):
    words = ["nohup", sys.executable, "-m", "reflexarc", "run", str(policy), "--port", str(port)]
    with plain_body(CONTRACT, port) as body:
        process = subprocess.Popen(
            [*words, "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        wait_until(lambda: drove(body), "a runtime that drives")
        process.send_signal(signal.SIGHUP)
        until_now = len(body.heard)
        wait_until(lambda: len(body.heard) > until_now + DRIVEN, "a runtime that goes on")
        assert body.last.verdict == pb.OK
        finished(process, signal.SIGTERM)


def test_a_recorder_ends_its_log_when_its_terminal_hangs_up(port: int, tmp_path: Path):
    log = tmp_path / "heard.mcap"
    with (
        plain_body(CONTRACT, port),
        started("record", "-o", log, "--port", port, "--json") as recorder,
    ):
        said_line(recorder, "reflexarc record:")
        wait_for_records(log, "retina", DRIVEN)
        finished(recorder, signal.SIGHUP)
    assert read_log(log).complete


def test_with_30_descriptors_it_drives_says_its_status_and_ends(
    policy: Path, port: int, tmp_path: Path
):
    log = tmp_path / "drive.mcap"
    command = f"ulimit -n 30; exec {sys.executable} -m reflexarc run {policy} --port {port} "
    words = ["sh", "-c", command + f"--record {log} --ticks 150 --json"]
    with plain_body(CONTRACT, port) as body:
        done = subprocess.run(
            words, capture_output=True, text=True, timeout=PATIENCE_S, check=False
        )
    assert done.returncode == 0, done.stderr
    assert len(body.watchdogs) >= 2
    assert body.last.verdict == pb.STOPPED
    assert both_levels_agree(log)


def test_a_loop_that_can_open_nothing_any_more_goes_on(policy: Path, port: int, tmp_path: Path):
    log = tmp_path / "drive.mcap"
    words = ("run", policy, "--no-guard", "--port", port, "--record", log, "--ticks", 150, "--json")
    with plain_body(CONTRACT, port) as body, started(*words) as runtime:
        wait_until(lambda: drove(body), "a runtime that drives")
        taken = {int(entry) for entry in os.listdir(f"/proc/{runtime.pid}/fd")}
        limit = min(set(range(len(taken) + 1)) - taken)
        resource.prlimit(runtime.pid, resource.RLIMIT_NOFILE, (limit, limit))
        finished(runtime)
    assert len(body.watchdogs) >= 2
    assert body.last.verdict == pb.STOPPED
    assert both_levels_agree(log)
