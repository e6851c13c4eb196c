"""Which form of the algorithm a run asks for."""

from reflexarc_trainer.batched_learner import BatchedLearner
from reflexarc_trainer.config import TrainConfig
from reflexarc_trainer.learner import Learner
from reflexarc_trainer.online_learner import OnlineLearner


def new_learner(config: TrainConfig) -> Learner:
    """A learner before its first step.

    Raises:
        WorldError: there is no such world, or it cannot give what the eye asks for.
    """
    return BatchedLearner(config) if config.learner.form == "batched" else OnlineLearner(config)
