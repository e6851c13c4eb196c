import math

import numpy as np
import pytest

from reflexarc_sim_bridge.simulation.scene import outlines_of_chunk
from reflexarc_sim_bridge.worlds.layers import Corridor
from reflexarc_sim_bridge.worlds.world import Edges, World


def test_the_walls_of_a_corridor_are_one_line_each_and_its_width_apart() -> None:
    for corridor in (Corridor(), Corridor(3.0, 2.5, 5.0), Corridor(1.0, 0.0)):
        world = World("walls", edges=Edges.UNBOUNDED, layers=(corridor,))
        ends, middles = [], []
        for i in range(-30, 30):
            walls = [o for j in range(-8, 8) for o in outlines_of_chunk(world, 1, i, j)]
            assert len(walls) == 2
            right, left = (o.corners_m for o in sorted(walls, key=lambda o: o.y_m))
            # From the far upper corner on, counter-clockwise: upper, lower, lower, upper.
            for k, right_k in ((0, 3), (1, 2)):
                gap_m = left[right_k, 1] - right[k, 1]
                assert gap_m == pytest.approx(corridor.width_m)
            begin_m, end_m = (left[2, 1] + right[1, 1]) / 2, (left[3, 1] + right[0, 1]) / 2
            if ends:
                assert begin_m == pytest.approx(ends[-1])
            ends.append(end_m)
            middles.append(end_m)
        assert np.abs(middles).max() <= corridor.meander_m + 1e-12
        assert np.abs(middles).max() >= 0.7 * corridor.meander_m


def test_a_corridor_passes_level_through_its_knots() -> None:
    world = World("w", edges=Edges.UNBOUNDED, layers=(Corridor(9.0, 3.0, 40.0),))

    def middle_m(i: int) -> float:
        walls = [o for j in range(-4, 5) for o in outlines_of_chunk(world, 1, i, j)]
        return float(np.mean([o.corners_m[1:3, 1].mean() for o in walls]))

    for knot in range(-4, 4):  # one every 20 m, which is 8 chunks
        here_m, there_m = middle_m(8 * knot), middle_m(8 * knot + 8)
        assert middle_m(8 * knot + 4) == pytest.approx((here_m + there_m) / 2)
        eighth = (1.0 - math.cos(math.pi / 8)) / 2
        assert middle_m(8 * knot + 1) == pytest.approx(here_m + eighth * (there_m - here_m))
