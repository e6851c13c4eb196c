import math

import numpy as np
import pytest

from reflexarc_baselines.headings import free_along_m, headings_rad
from reflexarc_runtime.contract.contract import PolicyContract
from reflexarc_runtime.contract.motion import sideways_actions


def test_headings_are_the_directions_of_the_motions() -> None:
    """A step aside at half the speed ahead leads atan(1/2) to its side."""
    assert headings_rad(PolicyContract()) == pytest.approx((0.0, math.pi / 4, -math.pi / 4))
    slow = PolicyContract(actions=sideways_actions(1.0, 0.5))
    assert headings_rad(slow) == pytest.approx((0.0, math.atan(0.5), -math.atan(0.5)))


def test_a_heading_is_free_as_far_as_the_shortest_of_its_nearest_rays() -> None:
    bearings = np.array([0.4, 0.1, -0.1, -0.4], np.float32)
    reach = np.array([[1.0, 3.0, 2.0, 4.0]], np.float32)
    assert free_along_m(reach, bearings, (0.0, 0.35, -0.45), 2).tolist() == [[2.0, 1.0, 2.0]]
    assert free_along_m(reach, bearings, (0.4, -0.4), 1).tolist() == [[1.0, 4.0]]
