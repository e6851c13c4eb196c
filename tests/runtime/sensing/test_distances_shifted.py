"""A scanner beside the robot's centre: the guard sees its returns from the centre."""

import math

import numpy as np
import pytest

from reflexarc_runtime.sensing.distances import beams_of_scan
from reflexarc_runtime.sensing.scan import Scan


def test_returns_are_where_they_are_and_the_unknown_stays_unknown():
    ranges_m = np.array([1.0, math.inf, math.nan, 2.0, -math.inf])
    scan = Scan(-math.pi / 2, math.pi / 2, ranges_m, x_m=0.3, y_m=-0.1)
    beams = beams_of_scan(scan)
    # To the right at 1 m, and to the front left at 2 m, by hand.
    right, left = (0.3, -1.1), (0.3 + 2 * math.sqrt(0.5), -0.1 + 2 * math.sqrt(0.5))
    for beam, (x_m, y_m) in ((0, right), (3, left)):
        assert beams.ranges_m[beam] * beams.fan.cos[beam] == pytest.approx(x_m)
        assert beams.ranges_m[beam] * beams.fan.sin[beam] == pytest.approx(y_m)
    assert beams.ranges_m[1] == math.inf
    assert not beams.ranges_m[2] > 0.0
    assert not beams.ranges_m[4] > 0.0
