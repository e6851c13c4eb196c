"""How fast the online learner learns on one core, and what the presets reach.

    python benchmarks/learner.py               updates a second, with and without the world
    python benchmarks/learner.py --presets     presets × seeds: contacts per 100 m on test worlds
    ... --json                                 the same for a program

Times are processor time of one thread, after compilation; each the best of several repetitions.
"""

import argparse
import dataclasses
import json
import time
from collections.abc import Callable
from typing import Any

import numba

from reflexarc_sim_bridge.kernel import sense_agent, step_agent
from reflexarc_sim_bridge.params import Agents, EyeParams, WorldParams
from reflexarc_sim_bridge.reference_field import measure
from reflexarc_trainer.config import TrainConfig
from reflexarc_trainer.learner import OnlineLearner
from reflexarc_trainer.online import Bytes, LearnerState, Rules, Scratch, learn_step
from reflexarc_trainer.presets import PRESETS
from reflexarc_trainer.weights import NetworkPolicy

STEPS = 100_000
REPETITIONS = 5
CONTACT_EVERY = 200


@numba.njit
def learn_only(rules: Rules, state: LearnerState, scratch: Scratch, steps: int) -> None:
    for step in range(steps):
        learn_step(rules, state, scratch, step % CONTACT_EVERY == 0)


@numba.njit
def world_only(
    world: WorldParams, eye: EyeParams, agents: Agents, retina: Bytes, steps: int
) -> None:
    for _ in range(steps):
        step_agent(world, agents, 0, 1.0, 0.0)
        sense_agent(world, eye, agents, 0, retina)


def per_second(run: Callable[[int], None]) -> float:
    run(10)
    best_s = min(timed(run) for _ in range(REPETITIONS))
    return STEPS / best_s


def timed(run: Callable[[int], None]) -> float:
    start_s = time.process_time()
    run(STEPS)
    return time.process_time() - start_s


def speeds() -> list[dict[str, Any]]:
    learner = OnlineLearner(TrainConfig())
    learner.run(STEPS)
    # The parts are timed apart on the learner's own state: this is what they see in a run.
    parts = (learner._rules, learner._state, learner._scratch)
    params, retina = learner._simulation.params, learner._scratch.retina
    return [
        {"what": "update alone", "per_second": per_second(lambda n: learn_only(*parts, n))},
        {"what": "world alone", "per_second": per_second(lambda n: world_only(*params, retina, n))},
        {"what": "update and world", "per_second": per_second(learner.run)},
    ]


def scores(steps: int | None, seeds: int, agents: int) -> list[dict[str, Any]]:
    OnlineLearner(TrainConfig()).run(1)  # compiles
    return [
        score(dataclasses.replace(config, seed=seed, steps=steps or config.steps), agents)
        for config in PRESETS.values()
        for seed in range(seeds)
    ]


def score(config: TrainConfig, agents: int) -> dict[str, Any]:
    learner = OnlineLearner(config)
    start_s = time.process_time()
    learner.run(config.steps)
    seconds = time.process_time() - start_s
    field = measure(NetworkPolicy(learner.network()), config.contract(), agents=agents)
    return {
        "preset": config.preset,
        "seed": config.seed,
        "steps": config.steps,
        "seconds": round(seconds, 2),
        "contacts_per_100m": round(field.contacts_per_100m, 2),
        "low": round(field.low, 2),
        "high": round(field.high, 2),
    }


def show(rows: list[dict[str, Any]]) -> None:
    print("".join(f"{name:>20}" for name in rows[0]))
    for row in rows:
        print(
            "".join(
                f"{v:>20,.0f}" if isinstance(v, float) and v > 1e3 else f"{v:>20}"
                for v in row.values()
            )
        )


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
