"""A policy that hangs once it decides, in a real runtime; and one that a machine held up."""

import json
import os
import signal
import time
from pathlib import Path

import pytest

from reflexarc_logs.reading.reader import Log, read_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.policy.model_file import policy_hash
from support.looping_policies import FOR_EVER, looping
from support.plain_body import SPECIAL, USUAL, PlainBody, plain_body
from support.policies import exported
from support.processes import Process, finished, reflexarc, started, wait_until

CONTRACT = PolicyContract()
MANY = 8


def drove(body: PlainBody, commands: int = 20) -> bool:
    return body.verdicts.count("OK") >= commands


def swapped(policy: Path, port: int, *more: str) -> str:
    """What the runtime answers, in one word."""
    said = reflexarc("swap", policy, "--port", port, "--backend", "onnxruntime", "--json", *more)
    (answer,) = json.loads(said.stdout)["answers"]
    return str(answer["outcome"])


def hold_up(runtime: Process) -> None:
    """Stop a process for longer than its watchdog waits, and less than the kernel's timer does."""
    os.kill(runtime.pid, signal.SIGSTOP)
    time.sleep(0.12)
    os.kill(runtime.pid, signal.SIGCONT)


def ended_in(log: Log) -> list[str]:
    """Whose decisions were ended."""
    said = [pb.Overrun.FromString(one.payload) for one in log.records("/robot0/overrun")]
    return [one.ended_policy for one in said if one.ended_policy]


@pytest.mark.long
@pytest.mark.parametrize("backend", ["onnxruntime", "numpy"])
def test_who_hangs_as_it_takes_over_is_rolled_back_and_who_is_held_up_is_not(
    port: int, tmp_path: Path, backend: str
):
    log, hangs = tmp_path / "drive.mcap", backend == "onnxruntime"
    first, healthy, bad = (tmp_path / f"{name}.onnx" for name in ("first", "healthy", "bad"))
    first.write_bytes(exported(CONTRACT, seed=1))
    healthy.write_bytes(exported(CONTRACT, seed=2))
    bad.write_bytes(looping(CONTRACT, FOR_EVER, at_intensity=SPECIAL))
    words = ("run", first, "--no-guard", "--allow-swap", "--backend", backend)
    with (
        plain_body(CONTRACT, port) as body,
        started(*words, "--port", port, "--record", log, "--json") as runtime,
    ):
        wait_until(lambda: drove(body), "a runtime that drives")
        assert swapped(healthy, port, "--while-moving", "--patience", "20") == "taken"
        for _ in range(MANY):
            hold_up(runtime)
            time.sleep(0.08)
        if hangs:
            body.intensity = SPECIAL
            assert swapped(bad, port, "--while-moving", "--patience", "20") == "rolled_back"
            body.intensity = USUAL
        until_now = body.verdicts.count("OK")
        wait_until(lambda: drove(body, until_now + 20), "a loop that is back")
        end = finished(runtime, signal.SIGINT)
    assert policy_hash(healthy.read_bytes()) == end["swaps"][-1]["policy_hash"]
    assert end["verdicts"]["OVERRUN"] >= MANY // 2
    ticks = [tick.decision for tick in read_log(log).ticks()]
    back = [tick.reason for tick in ticks if "rolled back to" in tick.reason]
    assert len(back) == hangs, back
    if hangs:
        assert ended_in(read_log(log))[-1] == policy_hash(bad.read_bytes())
    assert replay(log).verdict == "identical"
