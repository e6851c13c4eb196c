"""Runs through several worlds: a change of worlds loses nothing and invents nothing."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_sim_bridge.worlds.files import WorldFamily
from reflexarc_trainer.config.train_config import TrainConfig, TrainingWorld
from reflexarc_trainer.run import checkpoint, train
from reflexarc_trainer.run.train import TrainingProgress
from reflexarc_trainer.sarsa.forms import new_learner

WORLDS = (TrainingWorld("tier-05", 1.0), TrainingWorld("tier-30", 3.0))


@pytest.fixture(scope="module", params=["online", "batched"])
def config(
    request: pytest.FixtureRequest, small_config: TrainConfig, small_batched_config: TrainConfig
) -> TrainConfig:
    small = small_config if request.param == "online" else small_batched_config
    return dataclasses.replace(small, worlds=WORLDS)


def test_learner_changes_worlds_once_and_wherever_its_calls_are_cut(config: TrainConfig) -> None:
    whole, pieces = new_learner(config), new_learner(config)
    whole.run(config.steps)
    while pieces.step < whole.step:
        pieces.run(min(170, whole.step - pieces.step))
    mine, theirs = whole.arrays(), pieces.arrays()
    assert all(mine[name].tobytes() == theirs[name].tobytes() for name in mine)
    # The world's own counters began anew where it did: a quarter of the run is not in them.
    assert set(mine["world.state"]["steps"].tolist()) == {steps_in_the_last_world(config)}


def steps_in_the_last_world(config: TrainConfig) -> int:
    agents = config.learner.batched.agents if config.learner.form == "batched" else 1
    return config.steps * 3 // 4 // agents


def test_contacts_while_learning_are_counted_across_worlds(config: TrainConfig) -> None:
    learner = new_learner(config)
    learner.run(160)
    learner.mark()
    met = 0.0
    while learner.step < config.steps:
        before, stage = learner.arrays()["world.state"].copy(), learner.step
        learner.run(160)
        after = learner.arrays()["world.state"]
        crossed = stage < config.steps / 4 <= learner.step
        met += float((after["contacts"] - (0 if crossed else before["contacts"])).sum())
    assert learner.report().contacts_per_100m > 0.0
    driven_m = met / learner.report().contacts_per_100m * 100.0
    assert driven_m == pytest.approx(0.1 * (config.steps - 160), rel=0.1)


@pytest.mark.parametrize("after", [300, 800, 1500])
def test_run_resumed_in_either_world_equals_an_uninterrupted_one(
    after: int, config: TrainConfig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(train, "CHUNK_STEPS", 100)
    seen = [0]

    def listen(progress: TrainingProgress) -> None:
        seen[0] = progress.step

    config = dataclasses.replace(
        config, validation=dataclasses.replace(config.validation, points=1)
    )
    folders = (tmp_path / "broken", tmp_path / "whole")
    train.train(config, folders[0], progress=listen, should_stop=lambda: seen[0] >= after)
    train.resume(folders[0])
    train.train(config, folders[1])
    mine, theirs = (checkpoint.load(folder / "checkpoint.npz").arrays for folder in folders)
    assert all(mine[name].tobytes() == theirs[name].tobytes() for name in mine)


def test_policy_is_measured_in_the_last_world(config: TrainConfig) -> None:
    assert config.goal_world.name == "tier-30"


def test_a_family_of_worlds_is_learned_in(small_batched_config: TrainConfig) -> None:
    config = dataclasses.replace(small_batched_config, worlds=(TrainingWorld("randomised"),))
    assert isinstance(config.goal.source(), WorldFamily)
    learner = new_learner(config)
    learner.run(320)
    again = new_learner(config)
    again.restore(learner.arrays())
    for each in (learner, again):
        each.run(320)
    assert learner.weights.tobytes() == again.weights.tobytes()


def test_no_world_at_all_is_refused() -> None:
    with pytest.raises(UsageError, match="worlds: expected 1 to 64, got 0"):
        TrainConfig(worlds=())


def test_trace_does_not_reach_into_another_world(small_config: TrainConfig) -> None:
    config = dataclasses.replace(small_config, worlds=WORLDS)
    learner = new_learner(config)
    learner.run(config.steps // 4 - 1)
    assert learner.arrays()["trace"].any()
    learner.run(1)
    assert not np.any(learner.arrays()["trace"])
