"""How fast the learners learn, and what the presets reach.

    python benchmarks/learner.py               updates a second, with and without the world
    python benchmarks/learner.py --compile     compilation: at the first time, and later
    python benchmarks/learner.py --presets     presets × seeds: contacts per 100 m on test worlds,
                                               beside an agent that never steers
    ... --presets --names rover --seeds 4      of some
    ... --json                                 the same for a program

After compilation; each figure the best of several repetitions, in wall-clock seconds. The online
form runs on one thread, the batched one on as many as there are processors.
"""

import argparse
import dataclasses
import json
import os
import subprocess
import sys
import tempfile
import time
from typing import Any

import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.evaluation.reference_field import STEPS as FIELD_STEPS
from reflexarc_sim_bridge.evaluation.reference_field import measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.native.decorators import fused_free
from reflexarc_sim_bridge.native.threads import thread_count
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_trainer.config.presets import PRESETS
from reflexarc_trainer.config.train_config import NetworkConfig
from reflexarc_trainer.policy.weights import NetworkPolicy, network_of
from reflexarc_trainer.sarsa.forms import new_learner
from reflexarc_trainer.sarsa.learner_interface import driven_m
from reflexarc_trainer.sarsa.online.learner import new_learning, rules_for
from reflexarc_trainer.sarsa.online.state import LearnerState, Rules, Scratch
from reflexarc_trainer.sarsa.online.update import learn_step

STEPS = 262_144
REPETITIONS = 5
WORLD_AGENTS = 4096
WORLD_STEPS = 64
UPDATES = 50_000
RETINAS = 64
HIDDEN = (10, 32, 64)
BOUNDS = {"online 16-10-3": 1.2, "reflex": 2.0}
"""Millions of steps a second that we want, world included."""

FIRST_UPDATE = """
import time
from reflexarc_trainer.sarsa.forms import new_learner
from reflexarc_trainer.config.presets import PRESETS
start_s, start_cpu_s = time.perf_counter(), time.process_time()
learner = new_learner(PRESETS["{preset}"])
learner.run(1)
print(time.perf_counter() - start_s, time.process_time() - start_cpu_s)
"""


def speeds() -> list[dict[str, Any]]:
    """Millions of steps a second of the presets' learners, and of the world without one.

    A step is the world's: the batched form repeats an action for some, which are one transition.
    """
    units = {f"online 16-{h}-3, world left out": update_rate(h) for h in HIDDEN}
    online = {"online 16-10-3, world included": rate("online")}
    repeat, transitions = PRESETS["reflex"].learner.exploration.action_repeat, rate("reflex")
    batched = {
        f"reflex, world included, {thread_count()} threads": repeat * transitions,
        f"reflex, transitions of {repeat} steps": transitions,
    }
    rates = online | units | batched | {"world alone, 4,096 agents": world_rate()}
    return [
        {
            "what": what,
            "million_per_s": rate,
            "ns_each": round(1e3 / rate),
            "at least": BOUNDS.get(what.split(",")[0], "") if "included" in what else "",
        }
        for what, rate in rates.items()
    ]


def rate(preset: str) -> float:
    """Millions of transitions a second of a preset's learner, the best of several rounds."""
    learner = new_learner(PRESETS[preset])
    learner.run(STEPS // 8)  # compiles
    return max(million_per_s(learner, STEPS // REPETITIONS) for _ in range(REPETITIONS))


def update_rate(hidden: int) -> float:
    """Of the online learner on recorded retinas: how the cost grows with the network."""
    config = dataclasses.replace(PRESETS["online"], network=NetworkConfig(hidden=(hidden,)))
    rules, (state, scratch) = rules_for(config), new_learning(config)
    retinas = np.random.default_rng(0).integers(0, 256, (RETINAS, 16), np.uint8)
    learn_from(rules, state, scratch, retinas, 1)  # compiles
    best_s = float("inf")
    for _ in range(REPETITIONS):
        start_s = time.perf_counter()
        learn_from(rules, state, scratch, retinas, UPDATES)
        best_s = min(best_s, time.perf_counter() - start_s)
    return UPDATES / best_s / 1e6


@fused_free
def learn_from(
    rules: Rules,
    state: LearnerState,
    scratch: Scratch,
    retinas: npt.NDArray[np.uint8],
    updates: int,
) -> None:
    """Learn from retinas (n, inputs) one after another; every 32nd step ends in a contact."""
    for k in range(updates):
        contact = k % 32 == 0
        reward = rules.reward_contact if contact else rules.reward_step
        learn_step(rules, state, scratch, retinas[k % len(retinas)], contact, reward)


def compilation() -> list[dict[str, Any]]:
    """Seconds of wall clock and of processor until each form has learned for the first time.

    Imports are left out. In a process of its own each: with an empty cache, and once more.
    """
    rows = []
    for preset in ("reflex", "online"):
        with tempfile.TemporaryDirectory() as cache:
            for when, bound in (("first time", 20.0), ("later", 1.0)):
                done = subprocess.run(
                    [sys.executable, "-c", FIRST_UPDATE.format(preset=preset)],
                    env=os.environ | {"NUMBA_CACHE_DIR": cache},
                    capture_output=True,
                    text=True,
                    check=True,
                )
                wall_s, cpu_s = map(float, done.stdout.split())
                row = {"what": f"{preset}, {when}", "seconds": wall_s, "cpu_seconds": cpu_s}
                rows.append(row | {"at most": bound})
    return rows


def million_per_s(learner: Any, steps: int) -> float:
    """Of one round."""
    before, start_s = learner.step, time.perf_counter()
    learner.run(steps)
    return (learner.step - before) / (time.perf_counter() - start_s) / 1e6


def world_rate() -> float:
    """Million steps of the world alone a second: the best of several rounds."""
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


def scores(
    steps: int | None, seeds: int, agents: int, names: list[str] | None = None
) -> list[dict[str, Any]]:
    """Presets with every seed; `steps` in place of the preset's own."""
    return [
        score(
            dataclasses.replace(PRESETS[name], seed=seed, steps=steps or PRESETS[name].steps),
            agents,
        )
        for name in names or PRESETS
        for seed in range(seeds)
    ]


def score(config: Any, agents: int) -> dict[str, Any]:
    """One run: how long it learned, and what it makes on test worlds, beside a blind agent.

    Presets for the reference field are measured there, others in the world that they are meant
    for, those that turn per metre of their path.
    """
    learner = new_learner(config)
    start_s = time.perf_counter()
    learner.run(config.steps)
    seconds = time.perf_counter() - start_s
    policy = NetworkPolicy(network_of(learner))
    rate, blind = (in_world(config, who, agents) for who in (policy, BlindPolicy()))
    return {
        "preset": config.preset,
        "seed": config.seed,
        "steps": learner.step,
        "seconds": round(seconds, 2),
        "contacts_per_100m": round(rate, 2),
        "blind": round(blind, 2),
    }


def in_world(config: Any, policy: Any, agents: int) -> float:
    """Contacts per 100 m of progress along x; of bodies that turn, of the path."""
    world = config.goal_world
    field = measure(policy, config.contract(), agents=agents, world=world)
    driven = driven_m(config, world.drawn(0).dt_s, agents * FIELD_STEPS, field.distance_m)
    return 100.0 * field.contacts / driven


def show(rows: list[dict[str, Any]]) -> None:
    """Print as a table."""
    widths = [max(len(name), *(len(f"{row[name]}") for row in rows)) + 2 for name in rows[0]]
    print("".join(f"{name:>{width}}" for name, width in zip(rows[0], widths, strict=True)))
    for row in rows:
        print("".join(f"{cell(v):>{width}}" for v, width in zip(row.values(), widths, strict=True)))


def cell(value: object) -> str:
    """A value of the table."""
    return f"{value:.2f}" if isinstance(value, float) else f"{value}"


def main() -> None:
    """What the arguments ask for, as a table or as JSON."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--presets", action="store_true")
    parser.add_argument("--compile", action="store_true")
    parser.add_argument("--steps", type=int, help="of training, in place of the preset's own")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--names", nargs="+", choices=list(PRESETS), help="of presets; else all")
    parser.add_argument("--agents", type=int, default=4096, help="of the measurement")
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if min(options.seeds, options.agents, options.steps or 1) < 1:
        parser.error("expected --seeds, --agents and --steps of 1 or more")
    if options.presets:
        rows = scores(options.steps, options.seeds, options.agents, options.names)
    else:
        rows = compilation() if options.compile else speeds()
    print(json.dumps(rows, indent=2)) if options.json else show(rows)


if __name__ == "__main__":
    main()
