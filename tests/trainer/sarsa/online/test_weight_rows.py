"""The order of the online learner's weights leads back to the plain one."""

import numpy as np
import pytest

from reflexarc_trainer.sarsa.online.weight_rows import from_online, to_online


@pytest.mark.parametrize("hidden", [1, 10, 15, 16, 40])
def test_online_order_of_the_weights_leads_back(hidden: int) -> None:
    plain = np.arange(1.0, 17 * hidden + 3 * (hidden + 1) + 1)
    there = to_online(plain, 16, hidden, 3)
    np.testing.assert_array_equal(from_online(there, 16, hidden, 3), plain)
    assert np.count_nonzero(there) == len(plain)
