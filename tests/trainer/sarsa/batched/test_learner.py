"""The batched learner: threads change nothing, and every variant learns."""

import numpy as np
import pytest

from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.batched.learner import BatchedLearner
from support.learning import with_batched


def test_same_bits_on_one_thread_and_on_two(small_batched_config: TrainConfig) -> None:
    learned = []
    for threads in (1, 2):
        set_thread_count(threads)
        learner = BatchedLearner(small_batched_config)
        learner.run(1600)
        learned.append({name: a.tobytes() for name, a in learner.arrays().items()})
    assert learned[0] == learned[1]


@pytest.mark.parametrize(
    "changes",
    [
        {"epochs": 3, "optimiser": "radam"},
        {"minibatches": 3},
        {"shard_agents": 16, "max_gradient_norm": 0.01},
    ],
    ids=str,
)
def test_every_variant_learns_finite_weights(
    changes: dict[str, object], small_batched_config: TrainConfig
) -> None:
    learner = BatchedLearner(with_batched(small_batched_config, **changes))
    before = learner.weights
    learner.run(480)
    assert np.isfinite(learner.weights).all()
    assert not np.array_equal(learner.weights, before)


def test_averaged_weights_follow_the_last(small_batched_config: TrainConfig) -> None:
    learner = BatchedLearner(small_batched_config)
    average = learner.weights
    for _ in range(5):
        learner.run(160)
        average = 0.5 * average + 0.5 * learner.arrays()["weights"]
        np.testing.assert_allclose(learner.weights, average, atol=1e-6)
