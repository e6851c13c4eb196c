"""Drives in which something happens: contacts, guards, stops, overruns, marks; also under faults.

Real processes, on ports of their own. In lockstep, bodies that touch, and bodies whose guard steps
in; in real time, with faults on purpose, an operator who stops, resets and marks all the time, and
a watchdog that has no patience.
"""

import signal
import subprocess
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from support.fault_runs import free_ports
from support.processes import PATIENCE_S, Process, reflexarc, said_line, started


@dataclass(frozen=True)
class Drive:
    """One drive: what the body and its runtime are told, and what an operator does meanwhile."""

    name: str
    world: tuple[str, int]
    """Its name, and the seed."""
    run_flags: tuple[str, ...] = ()
    sim_flags: tuple[str, ...] = ()
    ticks: int = 0
    """In lockstep; 0: in real time, for as long as the operator has something to do."""
    rounds: int = 0
    """How often the operator marks, stops and resets."""


DRIVES = (
    Drive("contacts", ("tier-30", 3), ("--no-guard",), ticks=1500),
    Drive("moving", ("crossing", 7), ("--no-guard",), ticks=1500),
    Drive("guarded", ("tier-30", 4), ticks=2000),
    Drive("only-stops", ("clutter", 2), ("--guard-only-stops",), ticks=2000),
    Drive("operated", ("tier-30", 5), rounds=9),
    Drive("faults", ("tier-30", 6), ("--no-guard",), ("--faults", "seed:17"), rounds=6),
    Drive("guarded-faults", ("clutter", 8), (), ("--faults", "seed:21"), rounds=6),
    Drive("impatient", ("tier-30", 9), ("--watchdog-ms", "2"), rounds=6),
)


def make_drives(policy: Path, folder: Path) -> Iterator[Path]:
    """Drive each of them, and say where its log is."""
    for drive in DRIVES:
        yield _driven(drive, policy, folder)


def _driven(drive: Drive, policy: Path, folder: Path) -> Path:
    (port,) = free_ports(1)
    log, place = folder / f"{drive.name}.mcap", ("--port", port, "--robot", drive.name)
    world, seed = drive.world
    sim = ["sim", "--world", world, "--seed", seed, "--policy", policy, *place, *drive.sim_flags]
    run = ["run", policy, *place, *drive.run_flags, "--record", log]
    if drive.ticks:
        sim += ["--lockstep", "--steps", drive.ticks]
        run += ["--lockstep", "--ticks", drive.ticks]
    with started(*sim, "--state", folder / f"{drive.name}-state") as body:
        said_line(body, world)
        with started(*run) as runtime:
            for number in range(drive.rounds):
                _operate(number, place)
            _ended(runtime, is_told=not drive.ticks)
    return log


def _operate(number: int, place: tuple[object, ...]) -> None:
    """Let it drive, mark, stop, reset."""
    time.sleep(1.0 + number % 3)
    reflexarc("mark", f"round {number}: it should have turned here", *place)
    reflexarc("stop", "--reason", f"round {number}", *place)
    reflexarc("reset", *place)


def _ended(runtime: Process, *, is_told: bool) -> None:
    if is_told:
        runtime.send_signal(signal.SIGINT)
    try:
        _, complaint = runtime.communicate(timeout=PATIENCE_S)
    except subprocess.TimeoutExpired:
        raise SystemExit("a drive came to no end") from None
    if runtime.returncode:
        raise SystemExit(f"a drive failed: {complaint}")
