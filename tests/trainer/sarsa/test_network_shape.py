"""The input curve of a network."""

import numpy as np
import pytest

from reflexarc_trainer.config.train_config import NetworkConfig
from reflexarc_trainer.sarsa.network_shape import input_curve


def test_input_curve_is_the_power_of_the_intensity() -> None:
    curve = input_curve(NetworkConfig(input_power=3), np.float64)
    assert curve[[0, 51, 255]].tolist() == pytest.approx([0.0, 0.2**3, 1.0])
