"""The number of torch's threads."""

from learning_race.contenders import Contender, Theirs


def set_threads(contender: Contender) -> None:
    """Set the number of torch's threads that a rival has."""
    if isinstance(contender.learner, Theirs):
        import torch

        torch.set_num_threads(contender.learner.torch_threads)
