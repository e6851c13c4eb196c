"""A new learner, of the form that the run's configuration names."""

import numpy as np
import numpy.typing as npt

from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.sarsa.batched.learner import BatchedLearner
from reflexarc_trainer.sarsa.compile_ahead import compile_side_by_side
from reflexarc_trainer.sarsa.learner_interface import Learner
from reflexarc_trainer.sarsa.online.learner import OnlineLearner


def new_learner(config: TrainConfig, weights: npt.NDArray[np.float64] | None = None) -> Learner:
    """A learner before its first transition; its code is compiled if need be.

    Args:
        config: the run.
        weights: initial weights in the order of `policy/weights.py`; by default those that the
            seed gives: (parameters,).

    Raises:
        WorldError: the world does not exist, or does not support the eye.
    """
    compile_side_by_side(config)
    if config.learner.form == "batched":
        return BatchedLearner(config, weights)
    return OnlineLearner(config, weights)
