"""What the tests of the trainer share: a body that needs no world, and the smallest runs."""

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt
import pytest

from reflexarc_sim_bridge.native.threads import set_thread_count
from reflexarc_trainer.config.train_config import (
    BatchedConfig,
    LearnerConfig,
    NetworkConfig,
    TrainConfig,
    ValidationConfig,
)


class RecordedBody:
    """Plays slowly varying retinas and contacts, whatever it is told to do."""

    def __init__(self, seed: int, steps: int, contact_share: float = 0.05) -> None:
        generator = np.random.default_rng(seed)
        drift = np.cumsum(generator.normal(0.0, 25.0, (steps + 1, 1, 1, 16, 1)), axis=0)
        self._retinas = np.clip(drift, 0, 255).astype(np.uint8)
        self._contacts = generator.random((steps, 1)) < contact_share
        self._step = 0

    @property
    def stacks(self) -> npt.NDArray[np.uint8]:
        return self._retinas[self._step][:, np.newaxis]

    def sense(self) -> npt.NDArray[np.uint8]:
        return self._retinas[self._step]

    def step(self, _: npt.NDArray[np.int64]) -> npt.NDArray[np.bool_]:
        self._step += 1
        return self._contacts[self._step - 1]


@pytest.fixture(autouse=True)
def one_thread() -> Iterator[None]:
    """Worlds of a few agents: waking a second thread costs more than it brings."""
    set_thread_count(1)
    yield
    set_thread_count(0)


@pytest.fixture
def recorded_body() -> Callable[..., RecordedBody]:
    return RecordedBody


@pytest.fixture(scope="session")
def small_config() -> TrainConfig:
    """A run of about a tenth of a second."""
    return TrainConfig(
        seed=3, steps=2000, validation=ValidationConfig(points=4, agents=8, steps=20, discard=0)
    )


@pytest.fixture(scope="session")
def small_batched_config() -> TrainConfig:
    """The same for the batched form: 16 agents in two shards, a roll-out of 10 steps."""
    return TrainConfig(
        seed=3,
        steps=3200,
        network=NetworkConfig(hidden=(8,), units="relu", output="linear", input_power=2),
        learner=LearnerConfig(
            form="batched",
            target="expected",
            reward_centring=0.1,
            averaged_weights=0.5,
            batched=BatchedConfig(agents=16, shard_agents=8, rollout_steps=10, minibatches=2),
        ),
        validation=ValidationConfig(points=4, agents=8, steps=20, discard=0),
    )
