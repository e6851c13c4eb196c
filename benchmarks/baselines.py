"""What each baseline makes of its home world, and how many decisions a second it makes.

    python benchmarks/baselines.py [NAME…] [--agents 1024] [--steps 1000] [--batch 4096]

Contacts per 100 m on test worlds at ten decisions a second, each with its own eye and the
parameters that it ships with: on the reference field, and in its home world; beside it, in the same
worlds, a body with the same speeds that never steers and one that draws its actions. What was made
for range finders sees everything white. Decisions a second are those of the median batch, on one
thread, by the processor's time: other work beside it plays no part.
"""

import argparse
import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from reflexarc_baselines.baseline import Baseline, Remembering, Sees
from reflexarc_baselines.registry import HOMES, baseline_named
from reflexarc_runtime.arrays import RetinaBatch
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.state_spec import StateSpec
from reflexarc_runtime.policy.golden_check import start_of
from reflexarc_sim_bridge.evaluation.protocol.setting import as_driven
from reflexarc_sim_bridge.evaluation.reference_field import FieldScore, measure
from reflexarc_sim_bridge.evaluation.simple_policies import BlindPolicy, RandomPolicy
from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_sim_bridge.worlds.files import world_named
from reflexarc_sim_bridge.worlds.reference_contract import WORLD_NAME

RATE_HZ = 10.0
ROUNDS = 5


@dataclass(frozen=True)
class HomeFigures:
    """One baseline in its home world, beside two that do not look."""

    name: str
    home: str
    reference: float
    """Contacts per 100 m on the reference field."""
    at_home: FieldScore
    blind: FieldScore
    random: FieldScore
    decisions_hz: float

    @property
    def beats_random(self) -> bool:
        """Whether their intervals lie apart."""
        return self.at_home.high < self.random.low


def figures_of(name: str, agents: int, steps: int, batch: int) -> HomeFigures:
    """Measure a baseline, and two bodies with its speeds that do not look."""
    baseline, home = baseline_named(name), baseline_named(name).ORIGIN.home_world
    unseeing = replace(baseline.contract, state=StateSpec())

    def score(world: str, policy: Any, contract: PolicyContract) -> FieldScore:
        whitened = baseline.ORIGIN.sees is Sees.RANGES
        driven = as_driven(world_named(world), RATE_HZ, None, whitened)
        return measure(policy, contract, agents=agents, steps=steps, world=driven)

    at_home = score(home, baseline, baseline.contract)
    elsewhere = home != WORLD_NAME
    field = score(WORLD_NAME, baseline, baseline.contract) if elsewhere else at_home
    return HomeFigures(
        name,
        home,
        field.contacts_per_100m,
        at_home,
        score(home, BlindPolicy(), unseeing),
        score(home, RandomPolicy(1), unseeing),
        decisions_hz(baseline, batch),
    )


def decisions_hz(baseline: Baseline | Remembering, batch: int) -> float:
    """Decisions a second in batches: of the median one, after one that does not count."""
    shape = batch, *baseline.contract.retina.stack_shape
    looks = np.random.default_rng(0).integers(0, 256, shape, np.uint8)
    decide = _decider(baseline, batch)
    decide(looks)
    taken_s = []
    for _ in range(ROUNDS):
        begin_s = time.process_time()
        decide(looks)
        taken_s.append(time.process_time() - begin_s)
    return batch / statistics.median(taken_s)


def _decider(baseline: Baseline | Remembering, batch: int) -> Callable[[RetinaBatch], object]:
    memories = start_of(baseline.contract, batch)
    if memories is None:
        return cast("Baseline", baseline).decide
    remembering = cast("Remembering", baseline)
    return lambda looks: remembering.decide(looks, memories)


def main() -> None:
    """Print a row for each baseline, as a table of Markdown."""
    given = _arguments()
    set_thread_count(1)
    print(
        "| name | reference field | home world | there | never steering | random | beats random "
        "| decisions a second |"
    )
    print("|---" * 8 + "|", flush=True)
    for name in given.names or HOMES:
        row = figures_of(name, given.agents, given.steps, given.batch)
        print(_words(row), flush=True)


def _words(row: HomeFigures) -> str:
    scores = (row.at_home, row.blind, row.random)
    there, blind, random = (
        f"{s.contacts_per_100m:.2f} [{s.low:.2f}, {s.high:.2f}]" for s in scores
    )
    beats = "yes" if row.beats_random else "no"
    words = [f"`{row.name}`", f"{row.reference:.1f}", row.home, there, blind, random, beats]
    return f"| {' | '.join([*words, _rounded(row.decisions_hz / 1e6)])} M |"


def _rounded(value: float) -> str:
    """Two digits that count."""
    return f"{float(f'{value:.2g}'):g}"


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*")
    parser.add_argument("--agents", type=int, default=1024)
    parser.add_argument("--steps", type=int, default=1000)
    parser.add_argument("--batch", type=int, default=4096)
    return parser.parse_args()


if __name__ == "__main__":
    main()
