"""Small runs of both forms: one that is whole, and the configuration of others."""

import pytest

from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.run import train


@pytest.fixture(scope="session", params=["online", "batched"])
def config(
    request: pytest.FixtureRequest, small_config: TrainConfig, small_batched_config: TrainConfig
) -> TrainConfig:
    return small_config if request.param == "online" else small_batched_config


@pytest.fixture(autouse=True)
def short_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(train, "CHUNK_STEPS", 300)


@pytest.fixture(scope="session")
def whole_run(config: TrainConfig, tmp_path_factory: pytest.TempPathFactory) -> train.TrainResult:
    """An uninterrupted run, in `policy_path.parent`; tests read it and leave it alone."""
    return train.train(config, tmp_path_factory.mktemp("whole") / "run")
