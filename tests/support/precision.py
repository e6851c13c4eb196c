"""What is compared to the last digits."""

import dataclasses

from reflexarc_trainer.config.train_config import TrainConfig


def in_double(config: TrainConfig) -> TrainConfig:
    """The same run with the online form in double precision."""
    online = dataclasses.replace(config.learner.online, precision="float64")
    return dataclasses.replace(config, learner=dataclasses.replace(config.learner, online=online))
