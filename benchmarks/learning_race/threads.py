"""How many threads torch may take."""

from learning_race.contenders import Contender, Theirs


def set_threads(contender: Contender) -> None:
    """Give torch as many as the contender asks for."""
    if isinstance(contender.learner, Theirs):
        import torch

        torch.set_num_threads(contender.learner.torch_threads)
