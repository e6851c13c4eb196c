"""What is an eye by sector worth, and learning with the body that one has?

    python benchmarks/eyes.py [--seeds 10] [--agents 64] [--seconds 100] [--only WORD] [--json]

Each policy is learned anew from every seed, and drives through worlds of posts, boxes and walkers
with a body of 0.2 m that obeys with a lag of 0.1 s and brakes by 2 m/s², behind a scanner of 181
beams over 180° that sends after 1 to n steps of 0.1 s. Contacts per 100 m of way: mean over the
seeds, and the lowest and the highest. Each agent begins anew after a contact. Nothing is asserted.
"""

import argparse
import json
import statistics
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from reflexarc_runtime.contract.body_spec import BodySpec, Footprint
from reflexarc_runtime.contract.eye import BeamRule
from reflexarc_runtime.policy.policy import Policy
from reflexarc_sim_bridge.evaluation.driving.pilot import Pilot
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy
from reflexarc_sim_bridge.simulation.simulation import Simulation
from reflexarc_sim_bridge.worlds.layer_motion import Drift
from reflexarc_sim_bridge.worlds.layers import Scatter
from reflexarc_sim_bridge.worlds.seeds import test_seeds
from reflexarc_sim_bridge.worlds.shapes import Discs, Rectangles
from reflexarc_sim_bridge.worlds.world import Chassis, Scanner, World
from reflexarc_trainer.config.embodied import with_body
from reflexarc_trainer.config.presets import preset_named
from reflexarc_trainer.config.train_config import TrainConfig, TrainingWorld
from reflexarc_trainer.policy.weights import network_of
from reflexarc_trainer.run.validation import GreedyPolicy
from reflexarc_trainer.sarsa.forms import new_learner

BODY = BodySpec(Footprint(radius_m=0.2), actuation_delay_s=0.1, deceleration_mps2=2.0)
POINT = BodySpec()
TURN_RADPS2 = 6.0
AT_ONCE_S = 0.1
"""Inputs that are at most a step old: the sensor sends at every step."""

LAYERS: dict[str, tuple[Scatter, ...]] = {
    "posts 10 cm": (Scatter(0.4, shapes=(Discs((0.05, 0.05)),)),),
    "reference field": (Scatter(0.4, shapes=(Rectangles((0.3, 1.5), (0.3, 1.2)),)),),
    "boxes": (Scatter(0.1, shapes=(Rectangles((0.3, 1.5), (0.3, 1.2)),)),),
    "walkers": tuple(
        Scatter(0.02, shapes=(Discs((0.2, 0.3)),), motion=Drift(ahead_mps=x, left_mps=y))
        for x, y in ((0.0, 0.7), (0.0, -0.7), (-0.7, 0.0))
    ),
}


@dataclass(frozen=True)
class Row:
    """A policy of the table: how it learns, and by which rule it then sees."""

    name: str
    learns: TrainConfig
    rule: BeamRule
    age_s: float
    """Age up to which it takes inputs where it is measured."""


def rows() -> list[Row]:
    """The presets for lidars beside others that are given their bodies and their sensors."""
    one, sector = BeamRule.NEAREST_BEAM, BeamRule.SECTOR_MINIMUM
    lidar, rover_lidar = preset_named("lidar"), preset_named("rover-lidar")
    slow_s, slower_s = lidar.max_input_age_s, rover_lidar.max_input_age_s
    before = replace(
        lidar,
        worlds=(TrainingWorld("scanned"),),
        body=POINT,
        max_input_age_s=AT_ONCE_S,
        retina=replace(lidar.retina, beams=one),
    )
    one_beam = replace(lidar, retina=replace(lidar.retina, beams=one))
    rover = replace(
        preset_named("rover"),
        forward_mps=rover_lidar.forward_mps,
        angular_radps=rover_lidar.angular_radps,
    )
    return [
        Row("reflex, one beam", preset_named("reflex"), one, slow_s),
        Row("reflex, sector", preset_named("reflex"), sector, slow_s),
        Row("lidar of before, one beam", before, one, slow_s),
        Row("lidar of before, sector", before, sector, slow_s),
        Row("lidar, one beam", one_beam, one, slow_s),
        Row("lidar", lidar, sector, slow_s),
        Row("rover, one beam", rover, one, slower_s),
        Row("rover, sector", rover, sector, slower_s),
        Row("rover-lidar", rover_lidar, sector, slower_s),
    ]


def learned(config: TrainConfig) -> GreedyPolicy:
    """The greedy policy at the end of a run."""
    learner = new_learner(config)
    while learner.step < config.steps:
        learner.run(config.steps - learner.step)
    return GreedyPolicy(network_of(learner), config)


def contacts_per_100m(
    policy: Policy, row: Row, layers: tuple[Scatter, ...], agents: int, seconds: float
) -> float:
    """Let a crowd drive, each with the body and the sensor of the table."""
    contract = row.learns.contract()
    contract = replace(contract, retina=replace(contract.retina, beams=row.rule))
    chassis = Chassis(turn_acceleration_radps2=TURN_RADPS2)
    world = World("bench", layers=layers, chassis=chassis, scanner=Scanner())
    simulation = Simulation(with_body(world, BODY, row.age_s), contract, test_seeds(agents))
    pilot = Pilot(policy, contract, agents, simulation.dt_s)
    way_m, state = 0.0, simulation.params.agents.state
    for _ in range(round(seconds / simulation.dt_s)):
        simulation.sense()
        simulation.step(pilot.act(simulation.stacks))
        speed_mps = np.hypot(state["linear_mps"], state["lateral_mps"])
        way_m += float(speed_mps.sum()) * simulation.dt_s
    return 100.0 * int(simulation.contacts.sum()) / way_m


def measured(
    row: Row, policies: list[Policy], agents: int, seconds: float
) -> Iterator[tuple[str, list[float]]]:
    """The figures of each world, one a policy."""
    for world, layers in LAYERS.items():
        yield world, [contacts_per_100m(p, row, layers, agents, seconds) for p in policies]


def main() -> None:
    """Learn, measure, and print the table, line by line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--agents", type=int, default=64)
    parser.add_argument("--seconds", type=float, default=100.0)
    parser.add_argument("--only", default="", help="rows whose name holds this")
    parser.add_argument("--json", action="store_true")
    given = parser.parse_args()
    chosen = [row for row in rows() if given.only in row.name]
    scale, cache = (given.agents, given.seconds), dict[str, list[Policy]]()
    if not given.json:
        print(f"| policy | {' | '.join(LAYERS)} | seconds to learn |")
        print("|---|" + "---|" * (len(LAYERS) + 1))
    for blind in chosen[:1] + [row for row in chosen if row.name == "rover-lidar"]:
        row = replace(blind, name=f"blind, body of {blind.name.partition(',')[0]}")
        tell(row, dict(measured(row, [BlindPolicy(3)], *scale)), 0.0, as_json=given.json)
    for row in chosen:
        began_s, key = time.monotonic(), row.learns.hash
        if key not in cache:
            cache[key] = [learned(replace(row.learns, seed=seed)) for seed in range(given.seeds)]
        took_s = (time.monotonic() - began_s) / given.seeds
        figures = dict(measured(row, cache[key], *scale))
        tell(row, figures, took_s, as_json=given.json)


def tell(row: Row, figures: dict[str, list[float]], took_s: float, *, as_json: bool) -> None:
    """Print one line."""
    if as_json:
        print(json.dumps({"policy": row.name, **figures, "learning_s": took_s}), flush=True)
        return
    cells = [f"{statistics.mean(f):.1f} ({min(f):.1f} – {max(f):.1f})" for f in figures.values()]
    print(f"| {row.name} | {' | '.join(cells)} | {took_s:.1f} |", flush=True)


if __name__ == "__main__":
    main()
