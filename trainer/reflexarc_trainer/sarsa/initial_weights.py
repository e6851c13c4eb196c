"""Initial weights of a network, as one vector in the order of `policy/weights.py`."""

import math
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_trainer.config.learner_config import NetworkConfig
from reflexarc_trainer.config.train_config import TrainConfig


def initial_weights(config: TrainConfig) -> npt.NDArray[np.float64]:
    """The initial weights that a run's seed gives: (parameters,)."""
    return drawn_weights(config.contract(), config.network, config.seed)


def drawn_weights(
    contract: PolicyContract, config: NetworkConfig, seed: int
) -> npt.NDArray[np.float64]:
    """The initial weights of a seed: for each layer W by rows, then its biases.

    They are drawn with NumPy and not with torch, which the compiled learners do not load.

    Args:
        contract: gives the numbers of inputs and actions.
        config: the network.
        seed: of the run.

    Returns:
        (parameters,).
    """
    sizes = config.sizes(contract)
    generator = np.random.default_rng([seed, *sizes])
    normal, parts = config.initial_weights == "normal", []
    for below, here in pairwise(sizes):
        scale = 1.0 if normal else 1.0 / math.sqrt(below)
        parts += [scale * generator.normal(size=here * below)]
        parts += [generator.normal(size=here) * float(normal)]
    return np.concatenate(parts)
