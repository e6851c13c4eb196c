"""Where the policy drives, as a picture."""

import numpy as np

from reflexarc_trainer.config.train_config import TrainConfig, TrainingWorld
from reflexarc_trainer.policy.q_network import new_network
from reflexarc_trainer.run.plots import draw_occupancy, lateral_positions_m

EMPTY = TrainingWorld("empty", text='name = "empty"\nlayers = []\n')


def test_occupancy_of_an_agent_that_never_steers_is_even() -> None:
    config = TrainConfig(worlds=(EMPTY,))
    network = new_network(config.contract(), config.network, seed=0)
    with_bias = network.output.bias.detach()
    with_bias[:] = with_bias.new_tensor([50.0, 0.0, 0.0])
    positions_m = lateral_positions_m(network, config)
    assert positions_m.shape == (256 * 20,)
    counts, _ = np.histogram(positions_m, bins=4, range=(0.0, 20.0))
    # 256 agents: the standard deviation of a quarter's share is sqrt(1/4 · 3/4 / 256) = 0.027.
    np.testing.assert_allclose(counts / len(positions_m), 0.25, atol=4 * 0.027)
    assert draw_occupancy(network, config).startswith(b"\x89PNG")
