"""How fast the world is: agents sensing and stepping, warm, and what compilation costs.

    python benchmarks/world.py           a table
    python benchmarks/world.py --json    the same for a program

4,096 agents in the reference field, random actions held for 3 steps. The figure is the best of
several rounds: on a machine that does other work too, the least disturbed one. Compilation is
timed in new processes, with an empty cache and with the one that it leaves.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable

import numba
import numpy as np

from reflexarc_sim_bridge.reference_field import WORLD_NAME, reference_contract
from reflexarc_sim_bridge.seeds import training_seeds
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.worlds import world_named

AGENTS = 4096
ROUNDS = 12
STEPS = 30
HELD_STEPS = 3

FIRST_STEP = """
import time
import numpy as np
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.reference_field import reference_contract
from reflexarc_sim_bridge.worlds import world_named
start_s = time.perf_counter()
simulation = Simulation(world_named("reference-1"), reference_contract(), np.zeros(2, np.uint64))
simulation.sense()
simulation.step(np.zeros(2, np.int64))
print(time.perf_counter() - start_s)
"""


def rates(threads: int) -> dict[str, float]:
    """Millions of agent-steps a second: sensing, stepping, both."""
    numba.set_num_threads(threads)
    simulation = Simulation(world_named(WORLD_NAME), reference_contract(), training_seeds(AGENTS))
    drawn = np.random.default_rng(0).integers(0, 3, (STEPS // HELD_STEPS, AGENTS))
    actions = np.repeat(drawn, HELD_STEPS, axis=0)
    sense_s, step_s = [], []
    for _ in range(ROUNDS):
        sense_s.append(0.0)
        step_s.append(0.0)
        for row in actions:
            sense_s[-1] += timed_s(simulation.sense)
            step_s[-1] += timed_s(lambda row=row: simulation.step(row))  # type: ignore[misc]  # a default binds the row
    both_s = [a + b for a, b in zip(sense_s, step_s, strict=True)]
    best = {"sense": min(sense_s), "step": min(step_s), "sense_and_step": min(both_s)}
    return {name: AGENTS * STEPS / seconds / 1e6 for name, seconds in best.items()}


def compilation_s() -> dict[str, float]:
    """Seconds up to the first step, cache empty and cache filled."""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "NUMBA_CACHE_DIR": cache}
        return {state: first_step_s(environment) for state in ("cold", "warm")}


def first_step_s(environment: dict[str, str]) -> float:
    command = [sys.executable, "-c", FIRST_STEP]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    return float(done.stdout)


def timed_s(run: Callable[[], object]) -> float:
    start_s = time.perf_counter()
    run()
    return time.perf_counter() - start_s


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print JSON")
    as_json = parser.parse_args().json
    # Most first, so that the pool has all of its threads.
    threads = sorted({numba.get_num_threads(), 1}, reverse=True)
    found = {
        "agents": AGENTS,
        "million_agent_steps_per_s": {f"{n} threads": rates(n) for n in threads},
        "first_step_s": compilation_s(),
    }
    if as_json:
        print(json.dumps(found))
        return
    print(f"{'million agent-steps a second':30}{'sense':>8}{'step':>8}{'both':>8}")
    for n in threads:
        row = found["million_agent_steps_per_s"][f"{n} threads"]  # type: ignore[index]  # built above
        print(f"{f'{n} threads':30}" + "".join(f"{value:8.2f}" for value in row.values()))
    cold_s, warm_s = found["first_step_s"].values()  # type: ignore[attr-defined]  # built above
    print(f"first step: {cold_s:.1f} s with an empty cache, {warm_s:.2f} s from the cache")


if __name__ == "__main__":
    main()
