"""A terminal that hangs up, a loop without descriptors: the last command is safe, the log whole."""

import resource
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from campaigns.attacks.outcome import Outcome, held_if, last_line
from campaigns.attacks.stage import Scene, Stage
from reflexarc_logs.reading.reader import read_log
from reflexarc_runtime import messages_pb2 as pb
from support.processes import (
    Process,
    finished,
    said_line,
    started,
    wait_for_records,
    wait_until,
)
from support.ros2_base import HOLDS_FOR_EVER, rolled
from support.ros2_drives import driving

MOST_M = 0.3
SETTLED_S = 1.0
DESCRIPTORS = (30, 45)
"""Each peer on the bus takes some: among three others 30 are too few to begin, 45 enough."""
WATCHED_S = 2.0


def of_run(stage: Stage) -> Iterator[Outcome]:
    """`kill -HUP` and `kill -QUIT` of the runtime."""
    for number in (signal.SIGHUP, signal.SIGQUIT):
        with stage.driving("--record", "drive.mcap") as scene:
            yield _ended(scene, scene.loop, f"kill -{number.name[3:]} of `run --record`", number)


def under_nohup(stage: Stage) -> Iterator[Outcome]:
    """A hang-up that is ignored ends nothing."""
    words = ["nohup", sys.executable, "-m", "reflexarc", "run", stage.policy, "--no-guard"]
    with stage.standing() as scene:
        flags = ["--port", scene.port, "--record", scene.folder / "drive.mcap", "--json"]
        with Running(*words, *flags) as loop:
            scene.seen.wait_for(lambda lease: lease.state == "driving", "a drive")
            loop.send_signal(signal.SIGHUP)
            begun_m = scene.seen.way_m
            time.sleep(WATCHED_S)
            went_on_m = scene.seen.way_m - begun_m
            outcome = _ended(scene, loop, "kill -HUP of `nohup reflexarc run`", signal.SIGTERM)
    yield Outcome(
        outcome.attack,
        f"then {WATCHED_S:g} s, then SIGTERM",
        outcome.distance_m,
        f"it drives on, {went_on_m:.2f} m; {outcome.said}",
        held_if(outcome.held == held_if(True) and went_on_m > 0.5 * WATCHED_S),
    )


def without_descriptors(stage: Stage) -> Iterator[Outcome]:
    """A small limit from the start, and a table that is full in the middle of a drive."""
    for limit in DESCRIPTORS:
        yield _within(stage, limit)
    with stage.driving("--record", "drive.mcap") as scene:
        taken = {int(entry.name) for entry in Path(f"/proc/{scene.loop.pid}/fd").iterdir()}
        limit = min(set(range(len(taken) + 1)) - taken)
        resource.prlimit(scene.loop.pid, resource.RLIMIT_NOFILE, (limit, limit))
        yield _goes_on(scene, scene.loop, "`run` with no descriptor left", "in the drive")


def of_ros2(stage: Stage) -> Iterator[Outcome]:
    """`kill -HUP` of the bridge, with a base that holds its last twist for ever."""
    from support.ros2_robot import free_port

    with driving(stage.policy, free_port()) as drive:
        hung_up_ns = time.time_ns()
        finished(drive.bridge, signal.SIGHUP)
        time.sleep(1.0)
        told = drive.body.told
        roll = rolled(HOLDS_FOR_EVER, told, hung_up_ns, time.time_ns())
        zeros = next(n for n, word in enumerate(reversed(told)) if not word.is_standstill)
        yield Outcome(
            "kill -HUP of `ros2`",
            "a base that holds its last twist for ever and brakes with 2 m/s²",
            roll.distance_m,
            f"exit status 0; {zeros} zero twists at the end; standstill "
            f"after {roll.standstill_s:.2f} s",
            held_if(zeros >= 10 and roll.distance_m < 1.0),
        )


def of_the_others(stage: Stage) -> Iterator[Outcome]:
    """`kill -HUP` and `kill -QUIT` of `sim`, `record` and `play`."""
    for number in (signal.SIGHUP, signal.SIGQUIT):
        name = f"kill -{number.name[3:]}"
        with stage.driving() as scene:
            log = scene.folder / "heard.mcap"
            words = ("record", "-o", log, "--port", scene.port, "--json")
            with started(*words) as recorder:
                said_line(recorder, "reflexarc record:")
                wait_for_records(log, "retina", 20)
                finished(recorder, number)
            whole = read_log(log).complete
            said = f"exit status 0, log {'finished' if whole else 'not finished'}"
            yield Outcome(f"{name} of `record`", "in a drive", None, said, held_if(whole))
            journey = finished(scene.body, number)
            said = f"exit status 0, {journey['distance_m']:.2f} m told"
            yield Outcome(f"{name} of `sim`", "in a drive", None, said, held_if(True))
        port, _ = stage.place()
        with started("play", log, "--loop", "--port", port, "--json") as player:
            said_line(player, "reflexarc play:")
            time.sleep(0.5)
            report = finished(player, number)
            said = f"exit status 0, {report['messages']['retina']} retinas told"
            yield Outcome(f"{name} of `play`", "in the middle", None, said, held_if(True))


def _within(stage: Stage, limit: int) -> Outcome:
    """A limit from the start: it drives and ends well, or does not begin to drive at all."""
    attack, tried = f"`run` with {limit} descriptors", "from the start"
    with stage.standing() as scene:
        log = scene.folder / "drive.mcap"
        words = f"-m reflexarc run {stage.policy} --no-guard --port {scene.port} --record {log}"
        shell = f"ulimit -n {limit}; exec {sys.executable} {words}"
        with Running("sh", "-c", shell) as loop:
            wait_until(lambda: loop.poll() is not None or scene.seen.last_drive, "a drive or end")
            if loop.poll() is None:
                return _goes_on(scene, loop, attack, tried)
            assert loop.stderr is not None
            said = f"exit status {loop.returncode}, no command: {last_line(loop.stderr.read())}"
            stood = scene.seen.way_m == 0.0 and scene.seen.last_drive is None
            return Outcome(attack, tried, scene.seen.way_m, said, held_if(stood))


def _ended(scene: Scene, loop: Process, attack: str, number: signal.Signals) -> Outcome:
    """How a runtime ends by a signal, and the robot with it."""
    begun_m, log = scene.seen.way_m, scene.folder / "drive.mcap"
    loop.send_signal(number)
    loop.wait(30.0)
    time.sleep(SETTLED_S)  # a busy bus is late
    rolled_m, last = scene.seen.way_m - begun_m, scene.seen.last_command
    is_safe = last is not None and last.verdict == pb.STOPPED and not last.linear_mps
    is_whole = log.exists() and read_log(log).complete
    return Outcome(
        attack,
        "in a drive",
        rolled_m,
        f"exit status {loop.returncode}; last command {'safe' if is_safe else 'not safe'}; "
        f"log {'finished' if is_whole else 'not finished'}",
        held_if(is_safe and is_whole and loop.returncode == 0 and rolled_m < MOST_M),
    )


def _goes_on(scene: Scene, loop: Process, attack: str, tried: str) -> Outcome:
    begun_m = scene.seen.way_m
    time.sleep(WATCHED_S)
    went_on_m = scene.seen.way_m - begun_m
    ended = _ended(scene, loop, attack, signal.SIGTERM)
    return Outcome(
        attack,
        f"{tried}; {WATCHED_S:g} s, then SIGTERM",
        ended.distance_m,
        f"it drives on, {went_on_m:.2f} m; {ended.said}",
        held_if(ended.held == held_if(True) and went_on_m > 0.5 * WATCHED_S),
    )


class Running:
    """A process that ends with its context."""

    def __init__(self, *words: Any) -> None:
        pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
        self._process: Process = subprocess.Popen([str(word) for word in words], **pipes)

    def __enter__(self) -> Process:
        return self._process

    def __exit__(self, *reason: Any) -> None:
        if self._process.poll() is None:
            self._process.kill()
        self._process.communicate()


ATTACKS = (of_run, under_nohup, without_descriptors, of_ros2, of_the_others)
