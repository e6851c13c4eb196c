import pytest

from reflexarc_runtime.errors import WorldError
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.batched.learner import BatchedLearner
from support.short_lists import shorten


def test_a_learner_does_not_go_on_in_a_world_that_loses_obstacles(
    small_batched_config: TrainConfig,
) -> None:
    learner = BatchedLearner(small_batched_config)
    shorten(learner._simulation, 16, "boxes")
    with pytest.raises(WorldError, match=r"seed \d+: expected room for all boxes near an agent"):
        learner.run(160)
