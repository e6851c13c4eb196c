"""The layers of a network: how many units, where their weights lie, how inputs are scaled."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from reflexarc_runtime.contract import PolicyContract
from reflexarc_runtime.sensing.retina import FULL_SCALE
from reflexarc_trainer.config.learner_config import NetworkConfig
from reflexarc_trainer.sarsa.units import UNITS


class Layers(NamedTuple):
    """The shape of a network."""

    sizes: npt.NDArray[np.int64]
    """Inputs, hidden units, actions: (layers + 1,)."""
    units: int
    """Code of the hidden units."""
    output: int
    """Code of the output units."""

    @property
    def parameters(self) -> int:
        """Number of weights."""
        return int(((self.sizes[:-1] + 1) * self.sizes[1:]).sum())

    @property
    def computed(self) -> int:
        """Number of units that are not inputs."""
        return int(self.sizes[1:].sum())


def layers_for(config: NetworkConfig, contract: PolicyContract) -> Layers:
    """The shape of the network of a run."""
    sizes = config.sizes(contract)
    return Layers(np.array(sizes, np.int64), UNITS[config.units], UNITS[config.output])


def input_curve(config: NetworkConfig, dtype: npt.DTypeLike) -> npt.NDArray[Any]:
    """What the network sees of each byte: (byte / 255) to the input power: (256,)."""
    curve = (np.arange(FULL_SCALE + 1) / FULL_SCALE) ** config.input_power
    return curve.astype(dtype)
