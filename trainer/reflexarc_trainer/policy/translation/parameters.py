"""The parameters of a torch module as constants of a graph."""

import numpy as np
import numpy.typing as npt
import torch


def weights(tensor: torch.Tensor) -> npt.NDArray[np.float32]:
    """A parameter as the file holds it."""
    array: npt.NDArray[np.float32] = tensor.detach().float().numpy()
    return array
