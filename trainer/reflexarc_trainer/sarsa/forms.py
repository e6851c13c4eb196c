"""Which form of the algorithm a run asks for."""

import numpy as np
import numpy.typing as npt

from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.batched.learner import BatchedLearner
from reflexarc_trainer.sarsa.compile_ahead import compile_side_by_side
from reflexarc_trainer.sarsa.learner_interface import Learner
from reflexarc_trainer.sarsa.online.learner import OnlineLearner


def new_learner(config: TrainConfig, weights: npt.NDArray[np.float64] | None = None) -> Learner:
    """A learner before its first step.

    Args:
        config: the run.
        weights: to begin with; by default those that the seed gives: (parameters,).

    Raises:
        WorldError: there is no such world, or it cannot give what the eye asks for.
    """
    compile_side_by_side(config)
    if config.learner.form == "batched":
        return BatchedLearner(config, weights)
    return OnlineLearner(config, weights)
