"""The shape of a network as compiled code takes it: layer sizes, kinds of units, input curve.

What the network sees of a retina's byte b is x = (b / 255)ᵖ, with the input power p.
"""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.sensing.ray_values import FULL_SCALE
from reflexarc_trainer.config.learner_config import NetworkConfig
from reflexarc_trainer.sarsa.units import UNITS


class Layers(NamedTuple):
    """The layers of a network."""

    sizes: npt.NDArray[np.int64]
    """Inputs, hidden units, actions: (layers + 1,)."""
    units: int
    """Kind of the hidden units: a code of `units.py`."""
    output: int
    """Kind of the output units."""

    @property
    def parameters(self) -> int:
        """Number of weights and biases."""
        return int(((self.sizes[:-1] + 1) * self.sizes[1:]).sum())

    @property
    def computed(self) -> int:
        """Number of units whose values are computed: all but the inputs."""
        return int(self.sizes[1:].sum())


def layers_for(config: NetworkConfig, contract: PolicyContract) -> Layers:
    """The layers of a run's network."""
    sizes = config.sizes(contract)
    return Layers(np.array(sizes, np.int64), UNITS[config.units], UNITS[config.output])


def input_curve(config: NetworkConfig, dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """What the network sees of each byte: (256,)."""
    curve = (np.arange(FULL_SCALE + 1) / FULL_SCALE) ** config.input_power
    return curve.astype(dtype)
