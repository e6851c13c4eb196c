"""What tests of the learners share: variants of a configuration, a gradient by autograd."""

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from reflexarc_trainer.config.train_config import TrainConfig
from reflexarc_trainer.policy.q_network import QNetwork
from reflexarc_trainer.sarsa.online.learner import new_learning, rules_for
from reflexarc_trainer.sarsa.online.state import LearnerState, Rules, Scratch


def with_batched(config: TrainConfig, **changes: object) -> TrainConfig:
    """The same run with other settings of the batched form."""
    batched = dataclasses.replace(config.learner.batched, **changes)  # type: ignore[arg-type]  # by name
    return dataclasses.replace(config, learner=dataclasses.replace(config.learner, batched=batched))


def set_up(config: TrainConfig) -> tuple[Rules, LearnerState, Scratch]:
    """Constants, state and buffers of an online learner before its first transition."""
    return rules_for(config), *new_learning(config)


def gradient_of(network: QNetwork, retina: npt.NDArray[np.uint8], action: int) -> npt.NDArray[Any]:
    """∇Q(s, a) by autograd, in torch's order."""
    q = network(torch.from_numpy(retina.reshape(1, 1, 1, -1, 1)))[0, action]
    gradients = torch.autograd.grad(q, list(network.parameters()))
    return np.concatenate([g.numpy().ravel() for g in gradients])
