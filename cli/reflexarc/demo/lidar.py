"""Drives the learned policy on lidar scans: a text log goes through import, bus, runtime, replay.

The log may be that of a real robot. Without one, a small log in the CARMEN format is computed from
the reference field, and labelled as simulated.
"""

import contextlib
import math
import signal
import time
from pathlib import Path

import numpy as np

from reflexarc.demo.processes import Process, finish, free_port, started
from reflexarc.demo.results import LidarResult
from reflexarc_logs.importing.lidar_import import FORMATS, ImportReport, import_log
from reflexarc_logs.replaying.replay import replay
from reflexarc_runtime.contract.eye import RetinaSpec
from reflexarc_runtime.errors import LogError
from reflexarc_runtime.policy.policy import LoadedPolicy, load_policy
from reflexarc_runtime.sensing.retina import retina_from_scan
from reflexarc_runtime.sensing.scan import Scan
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_sim_bridge.worlds.seeds import test_seeds

_POLL_S = 0.1

BEAMS, SWEEP_RAD = 181, math.pi
SIMULATED_SCANS = 200
NO_RETURN_M = 81.9
"""What a SICK scanner writes for "no return"."""


def drive_on_scans(policy: Path, out: Path, file: Path | None) -> LidarResult:
    """Import a lidar's log, decide on every scan in lockstep, and replay.

    Raises:
        LogError: the file is not a lidar log of a known format.
        BusError: a process failed.
    """
    text = file or simulate_scans(load_policy(policy), out / "simulated-scans.log")
    scans, log = out / "lidar.mcap", out / "lidar-drive.mcap"
    imported = _import(text, scans)
    verdicts = _decide(policy, scans, log)
    report = replay(log)
    decided = sum(verdicts.values()) - verdicts.get("STOPPED", 0)
    return LidarResult(
        source=str(file) if file else "simulated: ray-cast from our own field",
        scans=imported.scans,
        ticks=decided,
        ok_share=verdicts.get("OK", 0) / max(1, decided),
        verdict=report.verdict,
        levels={level.level: level.identical for level in report.levels},
        log=str(log),
    )


def simulate_scans(policy: LoadedPolicy, path: Path) -> Path:
    """Write what a scanner would see on a drive through the reference field, as a CARMEN log."""
    sweep = RetinaSpec(rays=BEAMS, fov_rad=SWEEP_RAD * BEAMS / (BEAMS - 1))
    simulation = Simulation(world_named("reference-1"), reference_contract(sweep), test_seeds(1))
    pilot, lines = Pilot(policy, policy.contract, 1, simulation.dt_s), []
    for number in range(SIMULATED_SCANS):
        distances = simulation.distances()[::-1].astype(np.float64)
        ranges = np.where(distances < sweep.range_m, distances, NO_RETURN_M)
        place = f"{simulation.x_m[0]:.4f} {simulation.y_m[0]:.4f} 0"
        lines.append(f"FLASER {BEAMS} {_words(ranges)} {place} {place} {number / 10} sim 0\n")
        retina = retina_from_scan(
            Scan(-SWEEP_RAD / 2, SWEEP_RAD / 2, ranges), policy.contract.retina
        )
        simulation.step(pilot.act(retina[np.newaxis, np.newaxis]))
    path.write_text("".join(lines))
    return path


def _words(ranges: object) -> str:
    return " ".join(f"{distance:.3f}" for distance in np.asarray(ranges))


def _import(text: Path, log: Path) -> ImportReport:
    """Import a log of any known format; if none fits, the last format's error is raised."""
    *first, last = FORMATS
    for kind in first:
        with contextlib.suppress(LogError):
            return import_log(text, log, kind)
    return import_log(text, log, last)


def _while_both_live(runtime: Process, player: Process) -> None:
    """Wait for the player, however long its log is; if the runtime ends first, raise its error."""
    while player.poll() is None:
        if runtime.poll() is not None:
            finish(runtime)
        time.sleep(_POLL_S)


def _decide(policy: Path, scans: Path, log: Path) -> dict[str, int]:
    port = free_port()
    # Nothing moves by what is decided on a log, so there is nothing to guard.
    words = ("run", policy, "--no-guard", "--input", "scan", "--lockstep", "--record", log)
    with (
        started(*words, "--port", port, "--json") as runtime,
        started("play", scans, "--lockstep", "--port", port, "--json") as player,
    ):
        _while_both_live(runtime, player)
        finish(player)
        verdicts: dict[str, int] = finish(runtime, signal.SIGINT)["verdicts"]
    return verdicts
