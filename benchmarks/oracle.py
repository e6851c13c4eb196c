"""What the omniscient oracle costs, and how that grows: as ratios, in turns with a blind drive.

    python benchmarks/oracle.py

In the reference field, of the worlds of one cell of the suite `lite`: first how many times as long
as `drive` takes with an agent that never steers, at 10 and at 50 decisions a second; then how
much longer it takes for twice as many steps, twice as wide a world, twice as many decisions a
second. Both are warm, on one thread, and nothing is read from disk; medians over rounds.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from reflexarc_sim_bridge.evaluation.driving.drive import Extent, drive
from reflexarc_sim_bridge.evaluation.limits.oracle import least_contacts
from reflexarc_sim_bridge.evaluation.limits.rows import bare
from reflexarc_sim_bridge.evaluation.protocol.contender import BLIND, contender_of
from reflexarc_sim_bridge.evaluation.protocol.setting import Setting
from reflexarc_sim_bridge.evaluation.protocol.suite import SuiteCell, suite_named
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.world import World

LENGTH_M, WIDTH_M, RATE_HZ = 50.0, 20.0, 25.0
CELL = SuiteCell("reference", "reference-1")


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--rounds", type=int, default=7)
    rounds = parser.parse_args().rounds
    set_thread_count(1)
    print("oracle ÷ blind drive, of the same worlds and metres")
    for setting, rate_hz in ((Setting.FIELD, 10.0), (Setting.ROBOT, 50.0)):
        blind_s, oracle_s = in_turns([_blind(setting), _oracle(rate_hz=rate_hz)], rounds)
        print(f"  {rate_hz:4.0f} Hz {oracle_s / blind_s:6.1f}   ({oracle_s:.2f} s)")
    grown = {
        "twice the steps": _oracle(length_m=2 * LENGTH_M),
        "twice the width": _oracle(width_m=2 * WIDTH_M),
        "twice the rate": _oracle(rate_hz=2 * RATE_HZ),
        "twice all three": _oracle(2 * LENGTH_M, 2 * WIDTH_M, 2 * RATE_HZ),
    }
    base_s, *times_s = in_turns([_oracle(), *grown.values()], rounds)
    print(f"growth from {LENGTH_M:.0f} m, {WIDTH_M:.0f} m wide, {RATE_HZ:.0f} Hz ({base_s:.2f} s)")
    for name, time_s in zip(grown, times_s, strict=True):
        print(f"  {name:16} {time_s / base_s:5.2f}")


def in_turns(works: list[Callable[[], object]], rounds: int) -> list[float]:
    """Median seconds of each, round by round, so that a slow hour disturbs all alike."""
    taken: list[list[float]] = [[] for _ in works]
    for work in works:
        work()
    for _ in range(rounds):
        for times_s, work in zip(taken, works, strict=True):
            begin_s = time.perf_counter()
            work()
            times_s.append(time.perf_counter() - begin_s)
    return [statistics.median(times_s) for times_s in taken]


def _blind(setting: Setting) -> Callable[[], object]:
    suite = suite_named("lite")
    return lambda: drive(contender_of(BLIND), CELL, suite, setting)


def _oracle(
    length_m: float = LENGTH_M, width_m: float = WIDTH_M, rate_hz: float = RATE_HZ
) -> Callable[[], object]:
    """The oracle in as many worlds as the suite has."""
    field = world_named("reference-1")
    assert isinstance(field, World)
    world = bare(replace(field, width_m=width_m, dt_s=1.0 / rate_hz))
    extent = Extent(0, round(length_m * rate_hz))
    contract, seeds = contender_of(BLIND).contract, test_seeds(suite_named("lite").worlds).tolist()
    return lambda: np.mean([least_contacts(world, seed, contract, extent) for seed in seeds])


if __name__ == "__main__":
    main()
