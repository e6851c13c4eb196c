"""Trains PPO and DQN of Stable-Baselines3 on the reference field, and exports them as policy files.

    python benchmarks/rivals.py [--algorithms ppo dqn] [--seeds 10] [--decisions 1048576]

So that they stand in the suite beside our presets: same eye, actions and training worlds, the
settings that `learning_race/tuning.md` arrived at, our input curve and our repeated actions. A
decision is held for three steps of the world, as our learners hold theirs, so 2^20 decisions are
twice what the preset `reflex` learns from. Schedules follow the decisions, not the clock: the same
seed gives the same file on the same machine.
"""

import argparse
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch
from learning_race.contenders import Theirs, named
from learning_race.field import FieldVecEnv
from learning_race.learn import algorithm
from torch import nn

from reflexarc_runtime.contract.provenance import Provenance
from reflexarc_sim_bridge.worlds.reference_contract import reference_contract
from reflexarc_trainer.policy.provenance import commit, versions
from reflexarc_trainer.policy.sb3_export import export_sb3

TUNED = {"ppo": "ppo-tuned", "dqn": "dqn-tuned"}


class Curve(nn.Module):
    """What a model is shown of retinas: to the input power, in one row.

    Args:
        input_power: 1 or 2.
    """

    def __init__(self, input_power: int) -> None:
        super().__init__()
        self.squares = input_power == 2

    def forward(self, x: torch.Tensor) -> torch.Tensor:
        """Observations (n, inputs) of retinas in [0, 1]."""
        x = torch.flatten(x, 1)
        return x * x if self.squares else x


def main() -> None:
    """Train and export each algorithm with each seed; files that are there are left alone."""
    given = _arguments()
    torch.set_num_threads(1)
    for name in given.algorithms:
        for seed in range(given.seeds):
            path = given.out / f"{name}-{seed}.onnx"
            if not path.exists():
                path.parent.mkdir(parents=True, exist_ok=True)
                _train(name, seed, given.decisions, path)
            print(path)


def _train(name: str, seed: int, decisions: int, path: Path) -> None:
    learner = named(TUNED[name]).learner
    assert isinstance(learner, Theirs)
    model = _learned(learner, seed, decisions)
    provenance = Provenance(
        preset=f"sb3-{name}",
        seed=seed,
        config={**learner.settings, "decisions": decisions},
        versions=versions(),
        commit=commit(),
    )
    contract = replace(reference_contract(), provenance=provenance)
    export_sb3(model, contract, path, observe=Curve(learner.input_power))


def _learned(learner: Theirs, seed: int, decisions: int) -> Any:
    peak = learner.falling_rate
    assert peak is not None
    env = FieldVecEnv(
        learner.agents, seed, input_power=learner.input_power, held_steps=learner.held_steps
    )
    model = algorithm(learner.algorithm)(
        "MlpPolicy",
        env,
        seed=seed,
        device="cpu",
        learning_rate=lambda left: max(0.0, left) * peak,
        **learner.settings,
    )
    return model.learn(decisions)


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--algorithms", nargs="+", choices=sorted(TUNED), default=sorted(TUNED))
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--decisions", type=int, default=1 << 20)
    parser.add_argument("--out", type=Path, default=Path("runs/rivals"))
    return parser.parse_args()


if __name__ == "__main__":
    main()
