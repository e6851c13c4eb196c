"""SIGKILL at random moments of `run --record` with parts and a black box: what is lost?

    python tests/campaigns/kills.py [--kills 10] [--seed 0] [--most-s 6] [--json]

A simulated body drives on while one runtime after another is killed at a seeded moment: some of
them before the first tick, some around a seam of two parts, some while a black box is long open,
some while the recorder finishes its log. Each row: everything that is left is recovered and
replayed; what was hit is what was found on the disk. Exit status 1: a tick that was made more than
a second before the kill is on no disk, one is missing between two that are, a log does not replay,
or a manifest does not name what is there. A loss is the machine's if a thread of the runtime was
ready and got no processor for what it is longer than a second. A runtime that its own watchdog ends
on such a machine was killed then.
"""

import argparse
import json
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias

sys.path.insert(0, str(Path(__file__).parents[1]))  # the tests' support package

from reflexarc_logs.container.manifest import MANIFEST, read_manifest
from reflexarc_logs.reading.log_paths import log_paths
from reflexarc_logs.reading.reader import read_log
from reflexarc_logs.reading.recover import recover
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime import messages_pb2 as pb
from reflexarc_runtime.bus import Bus
from reflexarc_runtime.bus_config import BusConfig
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.errors import ReflexarcError
from reflexarc_runtime.messages.topics import TICK
from reflexarc_runtime.messages.wire import Message
from support.fault_runs import free_ports
from support.policies import exported
from support.processes import said_line, started
from support.starved import Starved

MOST_LOST_S = 1.0
PATIENCE_S = 60.0
START_S = 4.0
SEAM_S = 0.06
"""Within so long of a part's beginning: the one before it is being made durable."""
SHORT_BOX_S, LONG_BOX_S = 1, 60
FINISHING_S = 0.12
"""Within so long of being told to end a runtime is killed all the same."""
PARTIAL = ".partial"

Moment: TypeAlias = Literal["start", "drive", "seam", "box", "end"]
SHARES: dict[Moment, int] = {"start": 10, "drive": 25, "seam": 30, "box": 20, "end": 15}
"""When runtimes are killed, in hundredths of them."""

Ticks: TypeAlias = list[tuple[int, int]]
"""Index of each, and when it was heard."""
Logs: TypeAlias = dict[str, list[int]]
"""Indices of the ticks in each log."""


@dataclass
class Heard:
    """The ticks that a runtime made, and when they were heard."""

    ticks: Ticks = field(default_factory=list)

    def hear(self, message: Message) -> None:
        index = pb.Tick.FromString(message.payload).decision.index
        self.ticks.append((index, message.received_ns))


class NotBegunError(Exception):
    """A runtime made no tick: nothing to kill."""


@dataclass
class Kill:
    """One kill."""

    number: int
    moment: Moment
    """What it aims at."""
    rotate_s: float
    after_s: float
    hit: list[str] = field(default_factory=list)
    """What was open on the disk: a part, a seam, a box, the end; or that a watchdog was quicker."""
    ticks: int = 0
    parts: int = 0
    boxes: int = 0
    unborn: int = 0
    """Files in which not even the head was whole."""
    cut: list[str] = field(default_factory=list)
    """Logs that had not come to their end."""
    lost_s: float = 0.0
    lost_of_box_s: float = 0.0
    starved_s: float = 0.0
    """How long a thread of it got no processor, of the last two seconds."""
    failures: list[str] = field(default_factory=list)


def drawn(number: int, seed: int, most_s: float) -> Kill:
    """When to kill."""
    rng = random.Random(f"{seed}/{number}")
    (moment,) = rng.choices(list(SHARES), list(SHARES.values()))
    after_s = rng.uniform(0.0, START_S if moment == "start" else most_s)
    if moment == "seam":
        after_s = rng.uniform(0.0, SEAM_S)
    return Kill(number, moment, rng.choice((1.0, 1.0, 2.0)), after_s)


def strike(kill: Kill, policy: Path, port: int, heard: Heard, folder: Path) -> None:
    """Start a runtime, kill it, and judge what is left."""
    words = ["run", policy, "--port", port, "--record", folder / "whole"]
    words += ["--rotate-s", kill.rotate_s, "--black-box", 2, "-o", folder / "box"]
    words += ["--black-box-after", LONG_BOX_S if kill.moment == "box" else SHORT_BOX_S]
    heard.ticks.clear()
    with started(*words) as process:
        starved = Starved(process.pid)
        _wait(kill, heard, process, folder / "whole", starved)
        was_alive, struck_ns = process.poll() is None, time.monotonic_ns()
        process.kill()
        process.wait()
    kill.starved_s = starved.worst_s
    made = [(index, at_ns) for index, at_ns in heard.ticks if at_ns <= struck_ns]
    kill.ticks = len(made)
    kill.hit = list(_hit(kill, folder, was_alive=was_alive))
    whole, box = (_left_in(folder / name, kill) for name in ("whole", "box"))
    kill.parts, kill.boxes = len(whole), len(box)
    _judge_whole(kill, whole, made, struck_ns)
    _judge_box(kill, box, made, struck_ns)


def _wait(
    kill: Kill, heard: Heard, process: "subprocess.Popen[str]", parts: Path, starved: Starved
) -> None:
    """Until the moment of the kill, or of an end before it."""

    def until(holds: Callable[[], bool], patience_s: float) -> bool:
        end_s = time.monotonic() + patience_s
        while process.poll() is None and time.monotonic() < end_s:
            if holds():
                return True
            starved.look()
            time.sleep(0.002)
        return False

    def never() -> bool:
        return False

    if kill.moment != "start" and not until(lambda: bool(heard.ticks), PATIENCE_S):
        process.kill()
        raise NotBegunError(process.communicate(timeout=5)[1])
    if kill.moment == "seam":
        until(lambda: len(_logs_in(parts)) > 1, PATIENCE_S)
    until(never, kill.after_s)
    if kill.moment == "end":
        process.send_signal(signal.SIGINT)
        until(never, random.Random(kill.after_s).uniform(0.0, FINISHING_S))


def _logs_in(folder: Path) -> list[Path]:
    return [path for path in folder.glob("*.mcap*") if MANIFEST not in path.name]


def _hit(kill: Kill, folder: Path, *, was_alive: bool) -> Iterator[str]:
    """What was open when it was killed, by what lies on the disk."""
    struck_s = time.time()
    open_parts = list((folder / "whole").glob(f"*{PARTIAL}"))
    ended_s = [path.stat().st_mtime for path in (folder / "whole").glob("*.mcap")]
    if open_parts:
        yield "part"
    is_seam = len(open_parts) != 1 or struck_s - max(ended_s, default=0.0) < 2 * SEAM_S
    if was_alive and kill.moment != "end" and kill.ticks and is_seam:
        yield "seam"
    if list((folder / "box").glob(f"*{PARTIAL}")):
        yield "box"
    if kill.moment == "end" and was_alive:
        yield "end"
    if kill.moment != "end" and not was_alive:
        yield "ended"


def _left_in(folder: Path, kill: Kill) -> Logs:
    """Recover and replay what is there; the ticks of each log, in order."""
    if not folder.is_dir():
        return {}
    for partial in folder.glob(f"*{PARTIAL}"):
        try:
            if not recover(partial, partial.with_suffix("")).was_complete:
                kill.cut.append(f"{folder.name}/{partial.stem}")
        except ReflexarcError:
            kill.unborn += 1
    if not list(folder.glob("*.mcap")):
        return {}
    _compare_manifest(folder, kill)
    found = ((path, _replayed(path, kill)) for path in log_paths([folder]))
    return {f"{folder.name}/{path.name}": ticks for path, ticks in found if ticks}


def _compare_manifest(folder: Path, kill: Kill) -> None:
    there = set(folder.glob("*.mcap"))
    (manifest,) = folder.glob(f"*{MANIFEST}")
    named = {part.path for part in read_manifest(manifest)}
    # The last one may have been begun a moment before its line.
    kill.failures += ["the manifest lacks a part"] * (len(there - named) > 1)


def _replayed(path: Path, kill: Kill) -> list[int]:
    ticks = [tick.decision.index for tick in read_log(path).ticks()]
    if not ticks:
        return []  # killed behind the keyframe with which it begins
    report = replay(path)
    compared = sum(level.ticks for level in report.levels if level.level == "node")
    if report.exit_status or compared != len(ticks):
        said = f"status {report.exit_status}, {compared} of {len(ticks)} ticks"
        kill.failures.append(f"{path.name}: {said}")
    return ticks


def _lost_s(made: Ticks, kept: set[int], struck_ns: int) -> float:
    """How long before the kill the first tick was made that is nowhere."""
    missing_ns = [at_ns for index, at_ns in made if index not in kept]
    return (struck_ns - min(missing_ns)) * 1e-9 if missing_ns else 0.0


def _is_too_long(kill: Kill, lost_s: float) -> bool:
    """Longer than promised, by more than the machine withheld."""
    return lost_s - kill.starved_s > MOST_LOST_S


def _is_the_machine_s(kill: Kill) -> bool:
    lost_s = max(kill.lost_s, kill.lost_of_box_s)
    return lost_s > MOST_LOST_S and not _is_too_long(kill, lost_s)


def _judge_whole(kill: Kill, logs: Logs, made: Ticks, struck_ns: int) -> None:
    indices = [index for ticks in logs.values() for index in ticks]
    kill.lost_s = _lost_s(made, set(indices), struck_ns)
    gaps = indices != list(range(len(indices)))
    kill.failures += ["ticks are missing between two parts, or twice"] * gaps
    kill.failures += [f"{kill.lost_s:.2f} s lost"] * _is_too_long(kill, kill.lost_s)


def _judge_box(kill: Kill, logs: Logs, made: Ticks, struck_ns: int) -> None:
    """A box that was being written loses no more than a recording; what it had only in memory is
    lost, as it is meant to be.
    """
    for name, ticks in logs.items():
        gaps = ticks != list(range(ticks[0], ticks[0] + len(ticks)))
        kill.failures += ["a tick is missing in a box"] * gaps
        if name in kill.cut:
            since = [(index, at_ns) for index, at_ns in made if index >= ticks[0]]
            kill.lost_of_box_s = _lost_s(since, set(ticks), struck_ns)
            late = _is_too_long(kill, kill.lost_of_box_s)
            kill.failures += [f"{kill.lost_of_box_s:.2f} s of a box lost"] * late


@contextmanager
def _world(folder: Path) -> Iterator[tuple[Path, int, Heard]]:
    """A body that drives on, and somebody who hears each tick."""
    policy, heard = folder / "policy.onnx", Heard()
    policy.write_bytes(exported(PolicyContract(), seed=5))
    (port,) = free_ports(1)
    words = ("sim", "--policy", policy, "--port", port, "--state", folder / "state")
    with (
        started(*words) as body,
        Bus(BusConfig(port=port), time.monotonic_ns) as bus,
    ):
        said_line(body, "reference-1")
        bus.subscribe([TICK], heard.hear)
        yield policy, port, heard


def main() -> int:
    """Kill so many times, and print a line each."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kills", type=int, default=10)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--most-s", type=float, default=6.0, help="the longest a runtime lives")
    parser.add_argument("--json", action="store_true")
    flags = parser.parse_args()
    kills = []
    with tempfile.TemporaryDirectory() as place, _world(Path(place)) as (policy, port, heard):
        for number in range(flags.kills):
            kill = drawn(number, flags.seed, flags.most_s)
            try:
                with tempfile.TemporaryDirectory() as folder:
                    strike(kill, policy, port, heard, Path(folder))
            except NotBegunError as error:
                print(f"{number:4}  not begun: {error}", flush=True)
                continue
            kills.append(kill)
            print(json.dumps(asdict(kill)) if flags.json else _line(kill), flush=True)
    if not flags.json:
        print(_sum(kills))
    return int(any(kill.failures for kill in kills))


def _line(kill: Kill) -> str:
    return (
        f"{kill.number:4}  {kill.moment:5} {kill.after_s:5.2f} s  "
        f"hit {'+'.join(kill.hit) or '-':13} {kill.ticks:4} ticks  "
        f"{kill.parts} parts, {kill.boxes} boxes  lost {kill.lost_s:.2f} s, "
        f"of a box {kill.lost_of_box_s:.2f} s, starved {kill.starved_s:.2f} s  "
        f"{'; '.join(kill.failures) or 'ok'}"
    )


def _sum(kills: list[Kill]) -> str:
    hits = Counter(one for kill in kills for one in kill.hit)
    return (
        f"{len(kills)} kills, of which hit: "
        f"{', '.join(f'{what} {n}' for what, n in hits.most_common())}; "
        f"{sum(kill.ticks for kill in kills)} ticks, "
        f"{sum(kill.parts for kill in kills)} parts and {sum(kill.boxes for kill in kills)} boxes "
        f"replayed, {sum(kill.unborn for kill in kills)} without a head; "
        f"at most {max(kill.lost_s for kill in kills):.2f} s lost, of a box "
        f"{max(kill.lost_of_box_s for kill in kills):.2f} s; "
        f"over {MOST_LOST_S:g} s and the machine's: {sum(map(_is_the_machine_s, kills))}; "
        f"{sum(bool(kill.failures) for kill in kills)} failed"
    )


if __name__ == "__main__":
    sys.exit(main())
