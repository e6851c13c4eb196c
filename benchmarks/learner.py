"""How fast the learners learn, and what the presets reach.

    python benchmarks/learner.py               updates a second, with and without the world
    python benchmarks/learner.py --presets     presets × seeds: contacts per 100 m on test worlds
    ... --json                                 the same for a program

After compilation; each figure the best of several repetitions, in wall-clock seconds. The online
form runs on one thread, the batched one on as many as there are processors.
"""

import argparse
import dataclasses
import json
import time
from typing import Any

import numpy as np

from reflexarc_sim_bridge.reference_field import measure
from reflexarc_sim_bridge.simulation import Simulation
from reflexarc_sim_bridge.world_files import world_named
from reflexarc_trainer.forms import new_learner
from reflexarc_trainer.presets import PRESETS
from reflexarc_trainer.weights import NetworkPolicy

STEPS = 262_144
REPETITIONS = 5
WORLD_AGENTS = 4096
WORLD_STEPS = 64


def speeds() -> list[dict[str, Any]]:
    """Millions of steps a second of the presets' learners, and of the world without one."""
    rates = {"world alone, 4,096 agents": world_rate()}
    rates |= {f"preset {name}, world included": rate(name) for name in ("online", "reflex")}
    return [{"what": what, "million_per_s": rate} for what, rate in rates.items()]


def rate(preset: str) -> float:
    learner = new_learner(PRESETS[preset])
    learner.run(STEPS // 8)  # compiles
    return max(million_per_s(learner, STEPS // REPETITIONS) for _ in range(REPETITIONS))


def million_per_s(learner: Any, steps: int) -> float:
    before, start_s = learner.step, time.perf_counter()
    learner.run(steps)
    return (learner.step - before) / (time.perf_counter() - start_s) / 1e6


def world_rate() -> float:
    config = PRESETS["reflex"]
    seeds = np.arange(WORLD_AGENTS, dtype=np.uint64)
    simulation = Simulation(world_named("reference-1"), config.contract(), seeds)
    actions, best_s = np.zeros(WORLD_AGENTS, np.int64), float("inf")
    for _ in range(REPETITIONS):
        start_s = time.perf_counter()
        for _ in range(WORLD_STEPS):
            simulation.step_and_sense(actions)
        best_s = min(best_s, time.perf_counter() - start_s)
    return WORLD_AGENTS * WORLD_STEPS / best_s / 1e6


def scores(steps: int | None, seeds: int, agents: int) -> list[dict[str, Any]]:
    return [
        score(dataclasses.replace(config, seed=seed, steps=steps or config.steps), agents)
        for config in PRESETS.values()
        for seed in range(seeds)
    ]


def score(config: Any, agents: int) -> dict[str, Any]:
    learner = new_learner(config)
    start_s = time.perf_counter()
    learner.run(config.steps)
    seconds = time.perf_counter() - start_s
    field = measure(NetworkPolicy(learner.network()), config.contract(), agents=agents)
    return {
        "preset": config.preset,
        "seed": config.seed,
        "steps": learner.step,
        "seconds": round(seconds, 2),
        "contacts_per_100m": round(field.contacts_per_100m, 2),
        "low": round(field.low, 2),
        "high": round(field.high, 2),
    }


def show(rows: list[dict[str, Any]]) -> None:
    widths = [max(len(name), *(len(f"{row[name]}") for row in rows)) + 2 for name in rows[0]]
    print("".join(f"{name:>{width}}" for name, width in zip(rows[0], widths, strict=True)))
    for row in rows:
        print("".join(f"{cell(v):>{width}}" for v, width in zip(row.values(), widths, strict=True)))


def cell(value: object) -> str:
    return f"{value:.2f}" if isinstance(value, float) else f"{value}"


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--presets", action="store_true")
    parser.add_argument("--steps", type=int, help="of training, in place of the preset's own")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--agents", type=int, default=4096, help="of the measurement")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    rows = scores(options.steps, options.seeds, options.agents) if options.presets else speeds()
    print(json.dumps(rows, indent=2)) if options.json else show(rows)


if __name__ == "__main__":
    main()
