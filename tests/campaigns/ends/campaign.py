"""Many ends, dealt to several robots at once, beside a witness of the machine."""

import multiprocessing
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

from campaigns.ends import lives
from campaigns.ends.judge import Outcome
from campaigns.ends.kinds import KINDS
from campaigns.ends.replays import Replayed, replayed
from campaigns.ends.shift import Report, Shift, work
from campaigns.ends.witness import Overslept, read
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import Action
from support.looping_policies import FOR_EVER, looping
from support.policies import exported

A_SHIFT = 25
"""So many ends a robot."""
BACKENDS = ("numpy", "onnxruntime")


@dataclass
class Campaign:
    """All that was seen."""

    outcomes: list[Outcome] = field(default_factory=list)
    replays: list[Replayed] = field(default_factory=list)
    overslept: list[Overslept] = field(default_factory=list)
    failures: list[str] = field(default_factory=list)
    took_s: float = 0.0
    load: float = 0.0
    """Mean number of running processes, while robots drove."""


def run(ends: int, seed: int, parallel: int, only: str, folder: Path) -> Campaign:
    """Come to so many ends, then replay every log."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)  # under nohup every child would ignore it, rightly
    # Whoever it starts uses one core, so that robots side by side are not late by themselves.
    os.environ.update(OPENBLAS_NUM_THREADS="1", OMP_WAIT_POLICY="passive")
    shifts = dealt(ends, seed, only, folder)
    campaign, begun_s = Campaign(), time.monotonic()
    with witnessed(folder / "witness") as seen, _pool(parallel) as pool:
        for report in pool.map(work, shifts):
            _take(campaign, report)
        campaign.load = os.getloadavg()[1]
    campaign.overslept = read(seen)
    logs = campaign_logs(folder)
    with _pool(os.cpu_count() or 1) as pool:
        campaign.replays = list(pool.map(replayed, logs))
    campaign.took_s = time.monotonic() - begun_s
    return campaign


def dealt(ends: int, seed: int, only: str, folder: Path) -> list[Shift]:
    """Every kind in turn, in an order and at moments that the seed says, to robots of two kinds."""
    chance = random.Random(seed)
    numbers = [n for n, kind in enumerate(KINDS) if only in kind.name]
    hands: dict[tuple[str, str], list[tuple[int, int]]] = {}
    deck: list[int] = []
    for _ in range(ends):
        deck = deck or chance.sample(numbers, len(numbers))
        kind = KINDS[number := deck.pop()]
        backend = chance.choice([b for b in BACKENDS if kind.works_on(b)])
        hands.setdefault((kind.place, backend), []).append((number, chance.getrandbits(32)))
    policies = _policies(folder)
    shifts = [
        Shift(0, place, backend, tuple(hand[at : at + A_SHIFT]), policies[backend], folder)
        for (place, backend), hand in hands.items()
        for at in range(0, len(hand), A_SHIFT)
    ]
    chance.shuffle(shifts)
    return [replace(shift, robot=n) for n, shift in enumerate(shifts)]


@contextmanager
def witnessed(path: Path) -> Iterator[Path]:
    """A witness beside what happens inside; afterwards the file has what it saw."""
    words = [sys.executable, "-m", "campaigns.ends.witness", str(path)]
    env = {**os.environ, "PYTHONPATH": os.pathsep.join([str(lives.TESTS), *sys.path])}
    process = subprocess.Popen(words, env=env)
    try:
        yield path
    finally:
        process.send_signal(signal.SIGTERM)
        process.wait()


def campaign_logs(folder: Path) -> list[str]:
    """The logs of all runtimes, finished or not."""
    paths = folder.glob("*/run-*.mcap*")
    logs = {str(path).removesuffix(".partial") for path in paths}
    return sorted(logs)


def _take(campaign: Campaign, report: Report) -> None:
    campaign.outcomes += report.outcomes
    campaign.failures += report.failures
    said = [f"{o.kind}: {failure}" for o in report.outcomes for failure in o.failures]
    campaign.failures += said
    done = len(campaign.outcomes)
    print(f"{done} ends", *said, *report.failures, file=sys.stderr, flush=True)


def _pool(processes: int) -> ProcessPoolExecutor:
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(processes, context, _begin, (context.Lock(),))


def _begin(starts: AbstractContextManager[object]) -> None:
    lives.starts = starts


def _policies(folder: Path) -> dict[str, Path]:
    """One for each backend; whatever they see, they drive ahead at 1 m/s."""
    actions = tuple(Action(name, 1.0, 0.0) for name in ("one", "two", "three"))
    contract = replace(PolicyContract(), actions=actions)
    whole = {"numpy": exported(contract, seed=5), "onnxruntime": looping(contract, FOR_EVER, 200)}
    paths = {backend: folder / f"{backend}.onnx" for backend in whole}
    for backend, data in whole.items():
        paths[backend].write_bytes(data)
    return paths
