"""Network and learner: values that are refused, by the names of their fields."""

import math
from typing import Any

import pytest

from reflexarc_runtime.errors import UsageError
from reflexarc_trainer.config.train_config import (
    BatchedConfig,
    ExplorationConfig,
    LearnerConfig,
    NetworkConfig,
    OnlineConfig,
)

PARTS: dict[str, Any] = {
    "network": NetworkConfig,
    "learner": LearnerConfig,
    "exploration": ExplorationConfig,
    "learner.online": OnlineConfig,
    "learner.batched": BatchedConfig,
}


@pytest.mark.parametrize(
    ("part", "field", "value"),
    [
        ("learner", "trace_decay", 1.1),
        ("learner", "gamma", 1.0),
        ("learner", "reward_contact", math.inf),
        ("learner", "reward_centring", -0.1),
        ("learner", "averaged_weights", 1.0),
        ("learner", "form", "offline"),
        ("learner", "target", "largest"),
        ("network", "hidden", 0),
        ("network", "hidden", ()),
        ("network", "hidden", (8, 8, 8, 8)),
        ("network", "hidden", (8, 2.5)),
        ("network", "units", "softplus"),
        ("network", "output", "softmax"),
        ("network", "input_power", 1.5),
        ("exploration", "epsilon_end", -0.1),
        ("exploration", "held_actions", 0),
        ("learner.online", "alpha", 0.0),
        ("learner.online", "alpha", math.nan),
        ("learner.online", "alpha_end", 2.0),
        ("learner.online", "kappa", 0.5),
        ("learner.online", "step", "large"),
        ("learner.batched", "agents", 100),
        ("learner.batched", "rollout_steps", 0),
        ("learner.batched", "minibatches", 17),
        ("learner.batched", "optimiser", "sgd"),
        ("learner.batched", "learning_rate", math.nan),
        ("learner.batched", "max_gradient_norm", 0.0),
        ("learner.batched", "precision", "float16"),
    ],
)
def test_impossible_value_is_refused_by_the_name_of_its_field(
    part: str, field: str, value: Any
) -> None:
    with pytest.raises(UsageError, match=rf"{part}\.{field}: expected .*, got") as refusal:
        PARTS[part](**{field: value})
    assert "\n" not in str(refusal.value)


def test_plain_number_of_hidden_units_is_one_layer() -> None:
    assert NetworkConfig(hidden=12).hidden == (12,)  # type: ignore[arg-type]  # what old files say


def test_a_repeated_action_is_not_held_as_well() -> None:
    with pytest.raises(UsageError, match=r"held_actions: expected 1 where .*action_repeat"):
        ExplorationConfig(action_repeat=2, held_actions=2)


def test_batches_need_whole_shards() -> None:
    assert BatchedConfig(agents=48, shard_agents=16).batch_steps == 48 * 16
