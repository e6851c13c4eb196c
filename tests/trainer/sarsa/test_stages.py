"""Worlds one after another: a run that is saved between two of them goes on to the same bits."""

import dataclasses

import numpy as np
import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.config.training_world import TrainingWorld
from reflexarc_trainer.sarsa.forms import new_learner

WORLDS = (TrainingWorld("tier-05"), TrainingWorld("tier-30"))


@pytest.fixture(params=["online", "batched"])
def config(
    request: pytest.FixtureRequest, small_config: TrainConfig, small_batched_config: TrainConfig
) -> TrainConfig:
    chosen = {"online": small_config, "batched": small_batched_config}[request.param]
    return dataclasses.replace(chosen, worlds=WORLDS)


def test_an_interrupt_between_two_worlds_leaves_what_can_be_gone_on_with(
    config: TrainConfig, monkeypatch: pytest.MonkeyPatch
) -> None:
    straight = new_learner(config)
    straight.run(config.steps)

    stopped = new_learner(config)

    def interrupt(_: int) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(stopped, "_enter", interrupt)
    with pytest.raises(KeyboardInterrupt):
        stopped.run(config.steps)
    assert stopped.step == config.steps // 2

    resumed = new_learner(config)
    resumed.restore(stopped.arrays())
    resumed.run(config.steps - resumed.step)
    np.testing.assert_array_equal(resumed.weights, straight.weights)


@pytest.mark.parametrize("stage", [[-1], [2], [0, 0], []])
def test_a_stage_that_is_none_is_refused(config: TrainConfig, stage: list[int]) -> None:
    learner = new_learner(config)
    arrays = {**learner.arrays(), "stage": np.array(stage, np.int64)}
    with pytest.raises(UsageError, match="checkpoint: stage: expected 0 to 1, got"):
        learner.restore(arrays)
