"""Policies that never return, or too late: how far the robot rolls once a hang has begun."""

import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from campaigns.attacks.outcome import Outcome, counts, held_if, last_line
from campaigns.attacks.stage import Scene, Stage
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.messages.topics import COMMAND
from reflexarc_runtime.messages.wire import Message
from support.looping_policies import FOR_EVER, looping
from support.processes import Process, reflexarc, wait_until

MOST_M = 0.3
"""What a hang may roll: 0.1 s of validity and a period at 1.4 m/s, and what a busy machine adds."""
WATCHED_S = 4.0
TESTS = Path(__file__).parents[2]

FAULTS = {
    "python": "never returns, in Python",
    "numpy": "holds the interpreter's lock for ever, in NumPy",
    "graph": "never returns, in a graph that loops",
}


def at_load(stage: Stage) -> Iterator[Outcome]:
    """Policies that hang at once, or decide three times a second, are refused before a tick."""
    kinds = {"never returns": FOR_EVER, "decides a few times a second": 3_000_000}
    for name, trips in kinds.items():
        port, folder = stage.place()
        path = folder / "policy.onnx"
        path.write_bytes(looping(PolicyContract(), trips))
        words = ("--backend", "onnxruntime", "--no-guard", "--ticks", 3)
        done = reflexarc("run", path, "--port", port, *words)
        yield Outcome(
            f"a policy that {name}, which reproduces its golden vectors",
            f"`run`, a file of {path.stat().st_size / 1e3:.1f} kB",
            None,
            f"exit status {done.returncode}: {last_line(done.stderr)}",
            held_if(done.returncode == 2),
        )


def in_a_drive(stage: Stage) -> Iterator[Outcome]:
    """A hang at the 60th decision, each way in which a process can hang."""
    for fault, what in FAULTS.items():
        with stage.standing() as scene, harmed(scene, fault) as loop:
            heard = _drive_until_it_hangs(scene)
            begun_m, begun = scene.seen.way_at_last_drive_m, len(heard)
            time.sleep(WATCHED_S)
            rolled_m = scene.seen.way_m - begun_m
            late = [command for command in heard[begun:] if command.linear_mps]
            ended = loop.poll()
            if ended is None:
                loop.terminate()
            status = loop.wait(10.0)
            how = "ended by SIGTERM" if ended is None else "ended by the kernel"
            verdicts = Counter(pb.Verdict.Name(c.verdict) for c in heard[begun - 1 :])
            yield Outcome(
                f"a policy that {what}",
                f"at its 60th decision, {WATCHED_S:g} s",
                rolled_m,
                f"{counts(verdicts)}; {how}, exit status {status}; {scene.seen.lease.state}",
                held_if(rolled_m < MOST_M and not late and status in (0, -14)),
            )


def drowsy(stage: Stage) -> Iterator[Outcome]:
    """From the 60th decision on, three decisions a second."""
    with stage.standing() as scene, harmed(scene, "drowsy") as loop:
        heard = _drive_until_it_hangs(scene)
        begun_m, begun = scene.seen.way_at_last_drive_m, len(heard)
        time.sleep(WATCHED_S)
        rolled_m = scene.seen.way_m - begun_m
        loop.terminate()
        status = loop.wait(10.0)
        verdicts = Counter(pb.Verdict.Name(c.verdict) for c in heard[begun - 1 :])
        yield Outcome(
            "a policy that decides three times a second, from its 60th decision on",
            f"{WATCHED_S:g} s",
            rolled_m,
            f"{counts(verdicts)}; ended by SIGTERM, exit status {status}",
            held_if(rolled_m < MOST_M and status == 0 and not verdicts["OK"]),
        )


@contextmanager
def harmed(scene: Scene, fault: str) -> Iterator[Process]:
    """A runtime with a fault in its loop."""
    words = ("run", scene.stage.policy, "--no-guard", "--port", scene.port)
    process = subprocess.Popen(
        [sys.executable, "-m", "support.hanging_runtime", fault, *map(str, words)],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
        text=True,
        cwd=TESTS,
    )
    try:
        yield process
    finally:
        if process.poll() is None:
            process.kill()
        process.wait()


def _drive_until_it_hangs(scene: Scene) -> list[pb.Command]:
    """Wait until it has driven and has sent no driving command for a while; what it sent."""
    heard: list[pb.Command] = []
    last_s = [0.0]

    def hear(message: Message) -> None:
        command = pb.Command.FromString(message.payload)
        heard.append(command)
        if command.linear_mps:
            last_s[0] = time.monotonic()

    scene.seen.bus.subscribe([COMMAND], hear)
    wait_until(lambda: sum(c.linear_mps != 0.0 for c in heard) > 20, "a drive")
    wait_until(lambda: time.monotonic() - last_s[0] > 0.25, "a hang")
    return heard


ATTACKS = (at_load, in_a_drive, drowsy)
