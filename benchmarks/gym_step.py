"""What a step through Gymnasium costs, beside the same steps in a bare compiled loop.

    python benchmarks/gym_step.py           a table
    python benchmarks/gym_step.py --json    the same for a program

The reference field, random actions held for 3 steps, one thread, no episode ends. Figures are
microseconds for one agent to step and look: the best of several rounds, the ways in turn, since
other work disturbs all of them alike. Wrappers are those that `gymnasium.make` puts on.
"""

import argparse
import json
import time
from collections.abc import Callable, Iterator
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from reflexarc_sim_bridge.environments.registration import REFERENCE_ID
from reflexarc_sim_bridge.native.decorators import compiled_allocating
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.simulation.step import LOOK, MOVE
from reflexarc_sim_bridge.simulation.step_pointer import step_world
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME, reference_contract

AGENTS = (1, 64, 1024, 4096)
ROUNDS = 9
AGENT_STEPS = 30_000
HELD_STEPS = 3
UNLIMITED = 1 << 40
ENVIRONMENT = f"reflexarc.envs:{REFERENCE_ID}"

Actions = npt.NDArray[np.int64]
Way = Callable[[Actions], object]
"""Takes the actions of all steps: (steps, agents)."""


def bare_way(agents: int) -> Way:
    """All steps in one compiled loop."""
    seeds = np.arange(agents, dtype=np.uint64)
    simulation = Simulation(world_named(WORLD_NAME), reference_contract(), seeds)
    step, held = simulation.held_step()
    met = np.zeros(agents, np.bool_)

    def run(actions: Actions) -> None:
        bare(step, held, actions, met)

    return run


@compiled_allocating
def bare(step: int, held: int, actions: Actions, met: npt.NDArray[np.bool_]) -> None:
    """Steps and looks of all agents; actions are (steps, agents)."""
    for k in range(len(actions)):
        step_world(step, held, actions[k], met, MOVE + LOOK, 0, len(met))


def one_by_one(environment: gymnasium.Env[Any, Any]) -> Way:
    """One call of an environment a step."""
    environment.reset(seed=0)

    def run(actions: Actions) -> None:
        step = environment.step
        for action in actions[:, 0]:
            step(action)

    return run


def together(agents: int) -> Way:
    """One call of a vector environment a step."""
    environments = gymnasium.make_vec(ENVIRONMENT, agents, max_episode_steps=UNLIMITED)
    environments.reset(seed=0)

    def run(actions: Actions) -> None:
        for row in actions:
            environments.step(row)

    return run


def wrapped() -> Iterator[tuple[str, Way]]:
    """The environment as `gymnasium.make` gives it, then with ever fewer wrappers."""
    environment: Any = gymnasium.make(ENVIRONMENT, max_episode_steps=UNLIMITED)
    names = [f"gymnasium.make ({type(environment).__name__} outside)"]
    while environment is not environment.unwrapped:
        yield names[-1], one_by_one(environment)
        environment = environment.env
        names.append(f"from {type(environment).__name__} on")
    yield "unwrapped", one_by_one(environment)


def measured(ways: dict[str, Way], agents: int) -> dict[str, dict[str, float]]:
    """Microseconds a step of one agent for each way, and the ratio to the first one's."""
    steps = max(HELD_STEPS, AGENT_STEPS // agents)
    drawn = np.random.default_rng(0).integers(0, 3, (-(-steps // HELD_STEPS), agents))
    actions = np.repeat(drawn, HELD_STEPS, axis=0)
    rounds = [[timed_s(way, actions) for way in ways.values()] for _ in range(ROUNDS)]
    best_us = np.array(rounds[1:]).min(axis=0) / actions.size * 1e6
    return {
        name: {"us": float(us), "ratio": float(us / best_us[0])}
        for name, us in zip(ways, best_us, strict=True)
    }


def timed_s(way: Way, actions: Actions) -> float:
    """Seconds that a way takes for all steps."""
    start_s = time.perf_counter()
    way(actions)
    return time.perf_counter() - start_s


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--json", action="store_true", help="print JSON")
    as_json = parser.parse_args().json
    set_thread_count(1)
    found = {}
    for agents in AGENTS:
        ways = {"bare step": bare_way(agents), "gymnasium.make_vec": together(agents)}
        found[agents] = measured({**ways, **dict(wrapped())} if agents == 1 else ways, agents)
    if as_json:
        print(json.dumps({"agent_step": found}))
        return
    print(f"{'one agent steps and looks':44}{'µs':>8}{'ratio':>8}")
    for agents, rows in found.items():
        for name, row in rows.items():
            print(f"{f'{agents:4} × {name}':44}{row['us']:8.2f}{row['ratio']:8.2f}")


if __name__ == "__main__":
    main()
